// What a track is called: short on the map, whole in the details.

import { settings } from "./settings.js";

const END = 5; // digits of a serial number: enough to tell apart those of one city

/** The end of the serial number; "R 142" of what radar alone sees; else the track number. */
export function shortName(track) {
  if (track.serial) return track.serial.slice(-END);
  return track.source === "radar" ? `R ${track.name}` : track.name;
}

/** As the operator wants tracks to be labelled. */
export function labelName(track) {
  if (settings.labelBy === "number") return track.name;
  return settings.labelBy === "serial" && track.serial ? track.serial : shortName(track);
}
