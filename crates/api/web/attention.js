// Order of tracks by attention: watched ones, then unidentified ones, then distrusted ones.

import { settings } from "./settings.js";
import { isFlagged } from "./trust.js";

/** Lower values come first in the table. On the map they are drawn last, so on top, and are labelled first. @param {Track} track */
export function precedence(track) {
  if (settings.watched.has(track.watchId)) return 0;
  if (track.isUnknown) return 1;
  if (isFlagged(track)) return 2;
  return track.isDoubtful ? 4 : 3;
}
