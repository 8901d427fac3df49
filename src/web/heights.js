// Height as a colour: bands from the ground up, the same in the legend.

import { palette } from "./palette.js";
import { settings } from "./settings.js";
import { heightUnit, plainHeight } from "./units.js";

/** Where each band ends, metres above the ground where it is stated, else above sea level: 120 m is as high as most may fly. */
const TOPS_M = [30, 60, 90, 120, 150, Infinity];

const base = () => (heightUnit().endsWith("-agl") ? settings.groundM : 0);

/** The colour of a track by its height; of one whose height is not known, the quiet one. */
function heightColour({ properties: { alt_msl } }) {
  if (!Number.isFinite(alt_msl)) return palette.quiet;
  return palette[`band${TOPS_M.findIndex((top) => alt_msl - base() < top)}`];
}

/** Of each band its name in the palette and its words, the highest first. */
export function bands() {
  const words = TOPS_M.map((top, i) => {
    const from = plainHeight(base() + (TOPS_M[i - 1] ?? 0));
    return [`band${i}`, i === 0 ? `below ${plainHeight(base() + top)}` : top === Infinity ? `${from} and more` : `${from} to ${plainHeight(base() + top)}`];
  });
  return words.reverse();
}

/** What a track is drawn in: shapes say the source in any case. */
export const colourOf = (track) => (settings.colourBy === "height" ? heightColour(track) : palette[track.source]);
