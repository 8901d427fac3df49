// What an operator looks at first: what he watches, then what nobody has identified, then what cannot be trusted.

import { settings } from "./settings.js";
import { isFlagged } from "./trust.js";

/** Lower comes first in the table; on the map it is drawn last, so on top, and has its label first. */
export function precedence(track) {
  if (settings.watched.has(track.watchId)) return 0;
  if (track.isUnknown) return 1;
  if (isFlagged(track)) return 2;
  return track.isDoubtful ? 4 : 3;
}
