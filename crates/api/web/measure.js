// The measuring tool: legs between points or tracks, with distance and bearing. A leg from a track moves with it.

import { FONT, write } from "./fixtures.js";
import { direction } from "./format.js";
import { bearing } from "./geo.js";
import { palette } from "./palette.js";
import { distance } from "./units.js";

export class Measure {
  title = "Measure";
  hint = "Click places or tracks; Enter takes the middle of the map.";
  /** @type {{ x: number, y: number }[]} */
  points = []; // places or tracks

  /** @param {number} x @param {number} y @param {Track | null} track */
  add(x, y, track) {
    this.points.push(track ?? { x, y });
  }

  undo() {
    this.points.pop();
  }

  clear() {
    this.points = [];
  }

  legs() {
    return this.points.slice(1).map((to, i) => {
      const [east, north] = [to.x - this.points[i].x, to.y - this.points[i].y];
      return { length: Math.hypot(east, north), course: bearing(east, north) };
    });
  }

  words() {
    const legs = this.legs();
    const latest = legs.at(-1);
    if (!latest) return this.points.length ? "1 place" : "";
    const { length, course } = latest;
    const total = legs.reduce((sum, leg) => sum + leg.length, 0);
    return `${distance(length)} at ${direction(course)}${legs.length > 1 ? `; ${legs.length} legs, together ${distance(total)}` : ""}`;
  }

  /** @param {Context} context @param {View} view */
  draw(context, view) {
    const places = this.points.map(({ x, y }) => view.toScreen(x, y));
    drawCorners(context, places, false);
    context.font = FONT;
    context.textAlign = "center";
    context.textBaseline = "bottom";
    this.legs().forEach(({ length, course }, i) => {
      const [[ax, ay], [bx, by]] = [places[i], places[i + 1]];
      write(context, `${distance(length)} ${direction(course)}`, (ax + bx) / 2, (ay + by) / 2 - 3, palette.selected);
    });
  }
}

/**
 * A line through points on the screen, open or closed, with a square at each.
 * @param {Context} context @param {Point[]} places @param {boolean} isClosed
 */
export function drawCorners(context, places, isClosed) {
  context.save();
  context.strokeStyle = palette.selected;
  context.fillStyle = palette.halo;
  context.lineWidth = 1.5;
  context.beginPath();
  places.forEach(([px, py], i) => (i ? context.lineTo(px, py) : context.moveTo(px, py)));
  if (isClosed) context.closePath();
  context.stroke();
  context.beginPath();
  for (const [px, py] of places) context.rect(px - 3, py - 3, 6, 6);
  context.fill();
  context.stroke();
  context.restore();
}
