// What a track is called: short on the map, whole in the details.

import { settings } from "./settings.js";

/** Who a drone says it is, by whichever kind of identity it gives. */
export const idOf = ({ serial_number, registration_id, utm_id, specific_session_id } = {}) =>
  serial_number ?? registration_id ?? utm_id ?? specific_session_id ?? "";

const END = 5; // digits of a serial number: enough to tell apart those of one city

/** The callsign or the address of an aircraft; the end of a serial number; "R 142" of what radar alone sees; else the number. */
export function shortName(track) {
  const { callsign, icao24 } = track.properties.aircraft ?? {};
  if (callsign || icao24) return callsign ?? icao24;
  if (track.serial) return track.serial.slice(-END);
  return track.source === "radar" ? `R ${track.name}` : track.name;
}

/** As the operator wants tracks to be labelled. */
export function labelName(track) {
  if (settings.labelBy === "number") return track.name;
  return settings.labelBy === "serial" && track.serial ? track.serial : shortName(track);
}
