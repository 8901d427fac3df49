// Labels beside their symbols, where there is room: first those of what matters most; in a crowd the name alone, or nothing.

import { precedence } from "./attention.js";
import { FONT, write } from "./furniture.js";
import { labelName } from "./names.js";
import { palette } from "./palette.js";
import { settings } from "./settings.js";
import { climbArrow, plainHeight, plainSpeed } from "./units.js";

const LINE_PX = 13;
const BESIDE_PX = 9;
const BEYOND_BRACKET_PX = 17;
const SIDES = 4; // right and left above, right and left below
const STAY = 2; // trails that a label bears before it changes sides: one that jumps cannot be read

/** Name, and below it height, climb and speed in the units that the legend states. */
export function labelLines(track) {
  const second = [];
  if (Number.isFinite(track.properties.alt_msl)) second.push(plainHeight(track.properties.alt_msl) + climbArrow(track));
  if (Number.isFinite(track.speed)) second.push((track.derived ? "≈" : "") + plainSpeed(track.speed));
  return second.length ? [labelName(track), second.join(" ")] : [labelName(track)];
}

export function drawLabels(context, view, placed, alerted) {
  context.font = FONT;
  context.textAlign = "left";
  context.textBaseline = "middle";
  for (const [, px, py] of placed) view.room.take([px - 5, py - 5, px + 5, py + 5]);
  const rank = (track) => (track.id === settings.selected ? -2 : alerted.has(track.id) ? -1 : precedence(track));
  const character = context.measureText("0").width;
  const ranked = placed.map((one) => [rank(one[0]), one]).sort(([a], [b]) => a - b);
  for (const [, [track, px, py]] of ranked) {
    const all = labelLines(track);
    const spot = bestSpot(view.room, track, px, py, all, character) ?? (all.length > 1 ? bestSpot(view.room, track, px, py, all.slice(0, 1), character) : null);
    if (!spot) continue;
    track.place = spot.side;
    view.room.take(spot.box);
    const colour = track.id === settings.selected ? palette.selected : palette.ink;
    spot.lines.forEach((line, i) => write(context, line, spot.left, spot.top + LINE_PX * (i + 0.5), i ? palette.quiet : colour));
  }
}

/** Of the free sides the one with the fewest trails, and rather the one where the label was; null where none is free. */
function bestSpot(room, track, px, py, lines, character) {
  const width = Math.max(...lines.map((line) => line.length)) * character;
  const height = lines.length * LINE_PX;
  const beside = track.id === settings.selected ? BEYOND_BRACKET_PX : BESIDE_PX;
  let [best, least] = [null, Infinity];
  for (let i = 0; i < SIDES; i++) {
    const side = (track.place + i) % SIDES;
    const left = side % 2 === 0 ? px + beside : px - beside - width;
    const top = side < 2 ? py - height - 1 : py + 1;
    const box = [left - 2, top, left + width + 2, top + height];
    if (!room.isFree(box)) continue;
    const crowd = room.traced(box) + (i ? STAY : 0);
    if (crowd < least) [best, least] = [{ side, box, left, top, lines }, crowd];
  }
  return best;
}
