// Names of aircraft: one short name in the map, the table, the alerts and the conflicts; ids and whole serial numbers are in the
// details.

import { settings } from "./settings.js";

/** Identity that a drone reports, of any kind. @param {UasId} [uas] */
export const idOf = ({ serial_number, registration_id, utm_id, specific_session_id } = {}) =>
  serial_number ?? registration_id ?? utm_id ?? specific_session_id ?? "";

const END = 5; // minimum number of characters of a serial number, from its end
const MOST = 5000; // maximum number of remembered names of tracks

/** @type {Map<string, string>} */
const ends = new Map(); // end of each known serial number that no other one had when it appeared
/** @type {Set<string>} */
const doubled = new Set(); // serial numbers of several shown tracks
/** @type {Map<string, string>} */
let remembered = new Map(); // name by track id

/**
 * Names the shown tracks. `serials` are the serial numbers of those and of recently shown ones. A name stays the same while its
 * serial number is among them.
 * @param {Track[]} tracks @param {Set<string>} serials
 */
export function nameTracks(tracks, serials) {
  for (const serial of ends.keys()) if (!serials.has(serial)) ends.delete(serial);
  const fresh = [...serials].filter((serial) => !ends.has(serial));
  if (fresh.length) {
    const all = [...serials];
    for (const serial of fresh) ends.set(serial, endOf(serial, all.filter((other) => other !== serial)));
  }
  doubled.clear();
  const seen = new Set();
  for (const { serial } of tracks) {
    if (serial && seen.has(serial)) doubled.add(serial);
    seen.add(serial);
  }
  if (remembered.size > MOST) remembered = new Map();
  for (const track of tracks) remembered.set(track.id, shortName(track));
}

/**
 * Shortest end of a serial number, of at least 5 characters, that no other one has.
 * @param {string} serial @param {string[]} others
 */
function endOf(serial, others) {
  let length = END;
  while (length < serial.length && others.some((other) => other.endsWith(serial.slice(-length)))) length += 1;
  return serial.slice(-length);
}

/**
 * The service's name. The history has none: callsign or address of an aircraft; end of a serial number; "R 142" for a radar-only
 * track; else the track number.
 * @param {Track} track
 */
export function shortName(track) {
  if (track.properties.name) return track.properties.name;
  const { callsign, icao24 } = track.properties.aircraft ?? {};
  const reported = callsign || icao24;
  if (reported) return reported;
  const { serial } = track;
  // Two transmitters may send under one serial number.
  if (serial) return (ends.get(serial) ?? serial.slice(-END)) + (doubled.has(serial) ? ` #${track.name}` : "");
  return track.source === "radar" ? `R ${track.name}` : track.source === "camera" ? `C ${track.name}` : track.name;
}

/** Name of the track with that id; the id if the track was never shown. @param {string} id */
export const nameOf = (id) => remembered.get(id) ?? id;

/** Label of a track, as selected by the operator. @param {Track} track */
export function labelName(track) {
  if (settings.labelBy === "number") return track.name;
  return settings.labelBy === "serial" && track.serial ? track.serial : shortName(track);
}
