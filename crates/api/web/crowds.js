// Symbols that lie on one another: their number beside them, and the one that a click selects.

import { FONT, write } from "./fixtures.js";
import { palette } from "./palette.js";

const NEAR_PX = 7; // symbols that are nearer lie on one another
const EVEN_PX = 3; // difference of distances that a click does not tell apart

/**
 * Groups of symbols that lie on one another, [px, py, number] each.
 *
 * @param {Placed[]} placed most important last
 * @returns {Crowd[]}
 */
export function crowdsOf(placed) {
  /** @type {Map<number, Crowd[]>} */
  const cells = new Map();
  /** @type {Crowd[]} */
  const groups = [];
  /** @param {number} cx @param {number} cy */
  const key = (cx, cy) => cx * 65536 + cy;
  for (let i = placed.length - 1; i >= 0; i--) {
    const [, px, py] = placed[i];
    const [cx, cy] = [Math.floor(px / NEAR_PX), Math.floor(py / NEAR_PX)];
    const near = [-1, 0, 1].flatMap((dx) => [-1, 0, 1].flatMap((dy) => cells.get(key(cx + dx, cy + dy)) ?? []));
    const group = near.find(([gx, gy]) => Math.hypot(gx - px, gy - py) < NEAR_PX);
    if (group) {
      group[2] += 1;
    } else {
      /** @type {Crowd} */
      const made = [px, py, 1];
      groups.push(made);
      cells.set(key(cx, cy), [...(cells.get(key(cx, cy)) ?? []), made]);
    }
  }
  return groups.filter(([, , number]) => number > 1);
}

/**
 * Writes the number of each group below its symbols.
 *
 * @param {Context} context @param {View} view @param {Placed[]} placed
 */
export function drawCrowds(context, view, placed) {
  context.font = FONT;
  context.textAlign = "center";
  context.textBaseline = "middle";
  for (const [px, py, number] of crowdsOf(placed)) {
    view.space.occupy([px - 8, py + 9, px + 8, py + 21]);
    write(context, `×${number}`, px, py + 15, palette.ink);
  }
}

/**
 * The track that a click selects: the nearest; of several that lie on one another the next one after the selected.
 *
 * @param {Placed[]} placed @param {number} px @param {number} py @param {number} reach @param {string | null} selected
 * @returns {Track | null}
 */
export function chosenOf(placed, px, py, reach, selected) {
  const near = placed
    .map(([track, x, y]) => ({ track, apart: Math.hypot(x - px, y - py) }))
    .filter(({ apart }) => apart <= reach)
    .sort((one, other) => one.apart - other.apart);
  const even = near.filter(({ apart }) => apart <= near[0].apart + EVEN_PX).map(({ track }) => track);
  const at = even.findIndex(({ id }) => id === selected);
  return even[(at + 1) % even.length] ?? null;
}
