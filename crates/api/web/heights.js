// Colours by height: bands from the ground up, the same in the legend.

import { palette } from "./palette.js";
import { settings } from "./settings.js";
import { heightUnit, plainHeight } from "./units.js";

/**
 * Upper limits of the bands, in metres above ground if its height is given, else above sea level: 120 m is a common legal limit.
 */
const TOPS_M = [30, 60, 90, 120, 150, Infinity];
/** @type {Colour[]} */
const BANDS = ["band0", "band1", "band2", "band3", "band4", "band5"];

const base = () => (heightUnit().endsWith("-agl") ? (settings.groundM ?? 0) : 0);

/** Colour of a track by its height; neutral if the height is unknown. @param {Track} track */
function heightColour({ properties: { alt_msl } }) {
  if (!Number.isFinite(alt_msl)) return palette.quiet;
  return palette[BANDS[TOPS_M.findIndex((top) => alt_msl - base() < top)]];
}

/** Bands with their palette name and text, highest first. */
export function bands() {
  const words = BANDS.map((band, i) => {
    const [top, from] = [TOPS_M[i], plainHeight(base() + (TOPS_M[i - 1] ?? 0))];
    const to = plainHeight(base() + top);
    return /** @type {const} */ ([band, i === 0 ? `below ${to}` : top === Infinity ? `${from} and more` : `${from} to ${to}`]);
  });
  return words.reverse();
}

/** Colour of a track. The source is always visible by the shape. @param {Track} track */
export const colourOf = (track) => (settings.colourBy === "height" ? heightColour(track) : palette[track.source]);
