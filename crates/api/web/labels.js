// Labels beside their symbols, where space is free, in order of importance. In a crowd only the name is shown, or nothing.

import { FONT, write } from "./fixtures.js";
import { labelName } from "./names.js";
import { palette } from "./palette.js";
import { onChange, settings } from "./settings.js";
import { climbArrow, plainHeight, plainSpeed } from "./units.js";

const LINE_PX = 13;
const BESIDE_PX = 9;
const BEYOND_BRACKET_PX = 17;
const SIDES = 4; // above right and left, below right and left
const STAY = 2; // number of trails across a label before it changes sides: a jumping label cannot be read
const LAST_TO_REACH = 1; // last precedence with distant labels: selected, alerts, watch list and unidentified tracks
/** @typedef {Pick<FreeSpace, "isFree" | "traced">} Space */
/** @typedef {{ side: number, reach: number, box: Box, left: number, top: number, lines: string[] }} Spot */

/** @type {Space} */
const ANYWHERE = { isFree: () => true, traced: () => 0 }; // free space everywhere
const NEAR = [0];
const FAR = [0, 16, 34]; // further distances in pixels, with a line to the symbol, for important tracks

let known = new WeakMap(); // lines, by the track properties they were made of
onChange((patch) => {
  if (["units", "groundM", "labelBy"].some((name) => name in patch)) known = new WeakMap();
});

/** Name, and below it height, vertical trend and speed in the units of the legend. @param {Track} track */
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

/** `placed`: most important last. @param {Context} context @param {View} view @param {Placed[]} placed */
export function drawLabels(context, view, placed) {
  context.font = FONT;
  context.textAlign = "left";
  context.textBaseline = "middle";
  for (const [, px, py] of placed) view.space.occupy([px - 5, py - 5, px + 5, py + 5]);
  const character = context.measureText("0").width;
  for (let i = placed.length - 1; i >= 0; i--) {
    const [track, px, py, rank] = placed[i];
    const spot = spotFor(view.space, track, [px, py], rank, labelLines(track), character);
    if (!spot) continue;
    track.place = spot.side;
    view.space.occupy(spot.box);
    if (spot.reach) lead(context, [px, py], spot);
    const colour = track.id === settings.selected ? palette.selected : palette.ink;
    spot.lines.forEach((line, i) => write(context, line, spot.left, spot.top + LINE_PX * (i + 0.5), i ? palette.quiet : colour));
  }
}

/**
 * Position for both lines if free, else for the name; important tracks may be labelled at a distance. Null if nothing fits,
 * unless the track is selected.
 * @param {Space} space @param {Track} track @param {Point} place @param {number} rank @param {string[]} lines
 * @param {number} character
 */
function spotFor(space, track, place, rank, lines, character) {
  for (const reach of rank <= LAST_TO_REACH ? FAR : NEAR) {
    for (const some of lines.length > 1 ? [lines, lines.slice(0, 1)] : [lines]) {
      const spot = bestSpot(space, track, place, reach, some, character);
      if (spot) return spot;
    }
  }
  return track.id === settings.selected ? bestSpot(ANYWHERE, track, place, 0, lines, character) : null;
}

/**
 * The free side with the fewest trails, preferably the previous one; null if none is free.
 * @param {Space} space @param {Track} track @param {Point} place @param {number} reach @param {string[]} lines
 * @param {number} character
 */
function bestSpot(space, track, [px, py], reach, lines, character) {
  const width = Math.max(...lines.map((line) => line.length)) * character;
  const height = lines.length * LINE_PX;
  const beside = (track.id === settings.selected ? BEYOND_BRACKET_PX : BESIDE_PX) + reach;
  /** @type {Spot | null} */
  let best = null;
  let least = Infinity;
  for (let i = 0; i < SIDES; i++) {
    const side = (track.place + i) % SIDES;
    const left = side % 2 === 0 ? px + beside : px - beside - width;
    const top = side < 2 ? py - height - 1 - reach : py + 1 + reach;
    /** @type {Box} */
    const box = [left - 2, top, left + width + 2, top + height];
    if (!space.isFree(box)) continue;
    const crowd = space.traced(box) + (i ? STAY : 0);
    if (crowd < least) [best, least] = [{ side, reach, box, left, top, lines }, crowd];
  }
  return best;
}

/** A thin line from a symbol to its distant label. @param {Context} context @param {Point} place @param {Spot} spot */
function lead(context, [px, py], { box: [left, top, right, bottom] }) {
  context.strokeStyle = palette.quiet;
  context.lineWidth = 1;
  context.beginPath();
  context.moveTo(px, py);
  context.lineTo(left > px ? left : right, (top + bottom) / 2);
  context.stroke();
}
