// Filter of tracks by text, source, kind, height, integrity, zone and watch list. Map, table and exports share it.

import { KINDS, settings, SOURCES } from "./settings.js";
import { isFlagged, stateOf } from "./trust.js";

/**
 * A polygon of an area, with limits in metres above sea level; a ring is [[lng, lat], ...].
 * @typedef {{ name: string, floor_m: number, ceiling_m: number, rings: number[][][] }} Zone
 */

/** @type {Zone[]} */
let zones = [];

/** Takes the answer of /areas. @param {AreasAnswer} areas */
export function takeZones({ features }) {
  zones = features.flatMap(({ properties, geometry }) => {
    const { name = "", floor_m = -Infinity, ceiling_m = Infinity } = properties ?? {};
    return polygonsOf(geometry).map((rings) => ({ name, floor_m, ceiling_m, rings }));
  });
}

export const zoneNames = () => [...new Set(zones.map(({ name }) => name).filter(Boolean))];

/** @param {AreasAnswer["features"][number]["geometry"]} geometry */
function polygonsOf(geometry) {
  if (geometry?.type === "Polygon") return [geometry.coordinates];
  return geometry?.type === "MultiPolygon" ? geometry.coordinates : [];
}

/** Whether a track is shown. @param {Track} track */
export function matches(track) {
  return (
    settings.sources.has(track.source) &&
    settings.kinds.has(kindOf(track)) &&
    (!settings.flagged || isFlagged(track)) &&
    (!settings.watchedOnly || settings.watched.has(track.watchId)) &&
    (!settings.integrity || stateOf(track) === settings.integrity) &&
    isBetween(track.properties.alt_msl, settings.low ?? -Infinity, settings.high ?? Infinity) &&
    (!settings.zone || isInZone(track.properties)) &&
    (!settings.text || wordsOf(track).includes(settings.text.toLowerCase()))
  );
}

/** @param {Track} track */
function kindOf(track) {
  if (track.isDoubtful) return "doubtful";
  return track.serial || (track.source !== "radar" && track.source !== "camera") ? "identified" : "unknown";
}

/**
 * A track of unknown height may be anywhere, so a height filter never hides it.
 * @param {number | undefined} height @param {number} low @param {number} high
 */
const isBetween = (height, low, high) => !Number.isFinite(height) || (height >= low && height <= high);

/** Even-odd rule: a hole is outside. @param {TrackData} track */
function isInZone({ lat, lng, alt_msl }) {
  /** @param {Zone} zone */
  const isInside = ({ floor_m, ceiling_m, rings }) => isBetween(alt_msl, floor_m, ceiling_m) && rings.filter((ring) => isInRing(ring, lng, lat)).length % 2 === 1;
  return zones.some((zone) => zone.name === settings.zone && isInside(zone));
}

/** @param {number[][]} ring @param {number} x @param {number} y */
function isInRing(ring, x, y) {
  let isInside = false;
  for (let i = 0, j = ring.length - 1; i < ring.length; j = i++) {
    const [[ax, ay], [bx, by]] = [ring[i], ring[j]];
    if (ay > y !== by > y && x < ((bx - ax) * (y - ay)) / (by - ay) + ax) isInside = !isInside;
  }
  return isInside;
}

/** @param {Track} track */
function wordsOf(track) {
  const { contributors = [], uas_id = {}, aircraft = {}, also = [] } = track.properties;
  const words = [track.id, track.name, ...Object.values(uas_id), ...Object.values(aircraft)];
  for (const other of also) words.push(...Object.values(other.uas_id ?? {}), ...Object.values(other.aircraft ?? {}));
  for (const { sensor, track_number } of contributors) words.push(sensor, track_number);
  return words.join(" ").toLowerCase();
}

/** Text of the filter for the screen and prints: "radar only; above 60 m". @param {(metres: number) => string} height */
export function filterWords(height) {
  const { text, sources, kinds, flagged, watchedOnly, integrity, zone, low, high } = settings;
  return [
    text && `“${text}”`,
    sources.size < SOURCES.length && `sources: ${[...sources].join(", ") || "none"}`,
    kinds.size < Object.keys(KINDS).length && `kinds: ${[...kinds].map((kind) => KINDS[kind]).join(", ") || "none"}`,
    flagged && "flagged",
    watchedOnly && "watch list",
    integrity && `integrity: ${integrity}`,
    zone && `inside ${zone}`,
    low !== null && `from ${height(low)} up`,
    high !== null && `up to ${height(high)}`,
  ].filter(Boolean).join("; ");
}
