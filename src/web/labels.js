// Labels beside their symbols, where there is room: first those of what matters most; in a crowd the name alone, or nothing.

import { FONT, write } from "./furniture.js";
import { labelName } from "./names.js";
import { palette } from "./palette.js";
import { onChange, settings } from "./settings.js";
import { climbArrow, plainHeight, plainSpeed } from "./units.js";

const LINE_PX = 13;
const BESIDE_PX = 9;
const BEYOND_BRACKET_PX = 17;
const SIDES = 4; // right and left above, right and left below
const STAY = 2; // trails that a label bears before it changes sides: one that jumps cannot be read
const LAST_TO_REACH = 1; // of the precedences: selected, alerts, the watch list, and what nobody has identified
const ANYWHERE = { isFree: () => true, traced: () => 0 }; // a room in which all is free
const NEAR = [0];
const FAR = [0, 16, 34]; // pixels further out, with a line to the symbol: for what matters most

let known = new WeakMap(); // lines by the properties that they were made of
onChange((patch) => {
  if (["units", "groundM", "labelBy"].some((name) => name in patch)) known = new WeakMap();
});

/** Name, and below it height, climb and speed in the units that the legend states. */
function labelLines(track) {
  const before = known.get(track.properties);
  if (before) return before;
  const second = [];
  if (Number.isFinite(track.properties.alt_msl)) second.push(plainHeight(track.properties.alt_msl) + climbArrow(track));
  if (Number.isFinite(track.speed)) second.push((track.derived ? "≈" : "") + plainSpeed(track.speed));
  const lines = second.length ? [labelName(track), second.join(" ")] : [labelName(track)];
  known.set(track.properties, lines);
  return lines;
}

/** `placed`: what matters most is last. */
export function drawLabels(context, view, placed) {
  context.font = FONT;
  context.textAlign = "left";
  context.textBaseline = "middle";
  for (const [, px, py] of placed) view.room.take([px - 5, py - 5, px + 5, py + 5]);
  const character = context.measureText("0").width;
  for (let i = placed.length - 1; i >= 0; i--) {
    const [track, px, py, rank] = placed[i];
    const spot = spotFor(view.room, track, [px, py], rank, labelLines(track), character);
    if (!spot) continue;
    track.place = spot.side;
    view.room.take(spot.box);
    if (spot.reach) lead(context, [px, py], spot);
    const colour = track.id === settings.selected ? palette.selected : palette.ink;
    spot.lines.forEach((line, i) => write(context, line, spot.left, spot.top + LINE_PX * (i + 0.5), i ? palette.quiet : colour));
  }
}

/** Both lines if there is room, else the name; what matters most also further out; null where nothing fits, unless it is selected. */
function spotFor(room, track, place, rank, lines, character) {
  for (const reach of rank <= LAST_TO_REACH ? FAR : NEAR) {
    for (const some of lines.length > 1 ? [lines, lines.slice(0, 1)] : [lines]) {
      const spot = bestSpot(room, track, place, reach, some, character);
      if (spot) return spot;
    }
  }
  return track.id === settings.selected ? bestSpot(ANYWHERE, track, place, 0, lines, character) : null;
}

/** Of the free sides the one with the fewest trails, and rather the one where the label was; null where none is free. */
function bestSpot(room, track, [px, py], reach, lines, character) {
  const width = Math.max(...lines.map((line) => line.length)) * character;
  const height = lines.length * LINE_PX;
  const beside = (track.id === settings.selected ? BEYOND_BRACKET_PX : BESIDE_PX) + reach;
  let [best, least] = [null, Infinity];
  for (let i = 0; i < SIDES; i++) {
    const side = (track.place + i) % SIDES;
    const left = side % 2 === 0 ? px + beside : px - beside - width;
    const top = side < 2 ? py - height - 1 - reach : py + 1 + reach;
    const box = [left - 2, top, left + width + 2, top + height];
    if (!room.isFree(box)) continue;
    const crowd = room.traced(box) + (i ? STAY : 0);
    if (crowd < least) [best, least] = [{ side, reach, box, left, top, lines }, crowd];
  }
  return best;
}

/** A thin line from a symbol to its label that stands further out. */
function lead(context, [px, py], { box: [left, top, right, bottom] }) {
  context.strokeStyle = palette.quiet;
  context.lineWidth = 1;
  context.beginPath();
  context.moveTo(px, py);
  context.lineTo(left > px ? left : right, (top + bottom) / 2);
  context.stroke();
}
