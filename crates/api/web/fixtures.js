// Fixed elements of the map: range rings and bearing lines about the first radar, the sensors, scale and north arrow.

import { palette } from "./palette.js";
import { distance, roundDistance } from "./units.js";

export const FONT = '11px ui-monospace, "Cascadia Mono", "DejaVu Sans Mono", Menlo, Consolas, monospace';
const RING_APART_PX = 90;
const LINE_EVERY_DEG = 30;

/**
 * Text with an outline in the map's colour, readable on any background.
 * @param {Context} context @param {string} text @param {number} x @param {number} y @param {string} [colour]
 */
export function write(context, text, x, y, colour = palette.quiet) {
  context.lineWidth = 3;
  context.strokeStyle = palette.halo;
  context.fillStyle = colour;
  context.strokeText(text, x, y);
  context.fillText(text, x, y);
}

/** @type {Partial<Record<CanvasTextAlign, [number, number]>>} */
const EXTENT = { left: [0, 1], center: [0.5, 0.5], right: [1, 0] }; // shares of a text's width on either side

/**
 * Writes text if its place is free, otherwise leaves it out. Its position follows the context's alignment.
 * @param {Context} context @param {View} view @param {string} text @param {number} x @param {number} y
 * @param {string} [colour]
 */
export function writeFree(context, view, text, x, y, colour = palette.quiet) {
  const { width } = context.measureText(text);
  const [before, behind] = EXTENT[context.textAlign] ?? [0, 1];
  /** @type {Box} */
  const box = [x - before * width, y - 7, x + behind * width, y + 7];
  if (!view.space.isFree(box)) return;
  view.space.occupy(box);
  write(context, text, x, y, colour);
}

/** @param {Context} context @param {View} view */
export function drawRings(context, view) {
  const [cx, cy] = view.toScreen(0, 0);
  const step = roundDistance(RING_APART_PX / view.scale);
  const corners = [[0, 0], [view.width, 0], [0, view.height], [view.width, view.height]];
  const furthest = Math.max(...corners.map(([x, y]) => Math.hypot(x - cx, y - cy)));
  const inside = view.contains(cx, cy);
  const dx = Math.max(-cx, 0, cx - view.width);
  const dy = Math.max(-cy, 0, cy - view.height);
  const nearest = inside ? 0 : Math.hypot(dx, dy);
  // If the radar is off the screen, its rings are labelled on the line to the middle of the screen.
  const label = inside ? (15 * Math.PI) / 180 : Math.atan2(view.width / 2 - cx, cy - view.height / 2);

  context.font = FONT;
  context.lineWidth = 1;
  context.strokeStyle = palette.line;
  const first = Math.max(1, Math.ceil(nearest / view.scale / step));
  const last = Math.floor(furthest / view.scale / step);
  for (let i = first; i <= last; i++) {
    context.beginPath();
    context.arc(cx, cy, i * step * view.scale, 0, 2 * Math.PI);
    context.stroke();
  }
  drawBearings(context, view, cx, cy, step * view.scale, furthest);
  context.textAlign = "center";
  context.textBaseline = "middle";
  for (let i = first; i <= last; i++) {
    const radius = i * step * view.scale;
    writeFree(context, view, distance(i * step), cx + radius * Math.sin(label), cy - radius * Math.cos(label));
  }
}

/** @param {Context} context @param {View} view @param {number} cx @param {number} cy @param {number} from @param {number} to */
function drawBearings(context, view, cx, cy, from, to) {
  context.textAlign = "center";
  context.textBaseline = "middle";
  for (let angle = 0; angle < 360; angle += LINE_EVERY_DEG) {
    const [sin, cos] = [Math.sin((angle * Math.PI) / 180), Math.cos((angle * Math.PI) / 180)];
    context.lineWidth = 1;
    context.strokeStyle = palette.line;
    context.beginPath();
    context.moveTo(cx + from * sin, cy - from * cos);
    context.lineTo(cx + to * sin, cy - to * cos);
    context.stroke();
    const leaves = exit(cx, cy, sin, -cos, view);
    if (leaves <= from * 1.2) continue;
    const [x, y] = [cx + leaves * sin, cy - leaves * cos];
    writeFree(context, view, `${String(angle).padStart(3, "0")}°`, x, y);
  }
}

/**
 * Distance along a ray from a point to the view's edge, minus a margin; 0 if the ray does not cross the view.
 * @param {number} cx @param {number} cy @param {number} dx @param {number} dy @param {View} view
 */
function exit(cx, cy, dx, dy, view) {
  const inset = 18;
  let [enter, leave] = [0, Infinity];
  for (const [at, along, size] of [[cx, dx, view.width], [cy, dy, view.height]]) {
    if (Math.abs(along) < 1e-9) {
      if (at < inset || at > size - inset) return 0;
      continue;
    }
    const [one, other] = [(inset - at) / along, (size - inset - at) / along];
    enter = Math.max(enter, Math.min(one, other));
    leave = Math.min(leave, Math.max(one, other));
  }
  return enter < leave ? leave : 0;
}

/** Draws each radar as a square with its beam, and its name. @param {Context} context @param {View} view @param {Radar[]} radars */
export function drawRadars(context, view, radars) {
  context.font = FONT;
  context.textAlign = "left";
  context.textBaseline = "top";
  for (const { id, x, y } of radars) {
    const [px, py] = view.toScreen(x, y);
    if (!view.contains(px, py, 100)) continue;
    context.lineWidth = 1.5;
    context.strokeStyle = palette.ink;
    context.fillStyle = palette.halo;
    context.beginPath();
    context.rect(px - 5, py - 5, 10, 10);
    context.fill();
    context.moveTo(px, py);
    context.lineTo(px + 9, py - 9);
    context.stroke();
    writeFree(context, view, id, px + 9, py + 5, palette.ink);
  }
}

/** Box of the scale and the north arrow. @param {View} view @returns {Box} */
export const scaleBox = (view) => [0, view.height - 46, 190, view.height];

/** @param {Context} context @param {View} view */
export function drawScale(context, view) {
  const metres = roundDistance(60 / view.scale);
  const length = metres * view.scale;
  const [x, y] = [16, view.height - 16];
  context.strokeStyle = palette.ink;
  context.lineWidth = 1.5;
  context.beginPath();
  context.moveTo(x, y - 5);
  context.lineTo(x, y);
  context.lineTo(x + length, y);
  context.lineTo(x + length, y - 5);
  context.stroke();
  context.font = FONT;
  context.textAlign = "left";
  context.textBaseline = "bottom";
  write(context, distance(metres), x, y - 7, palette.ink);

  const nx = x + length + 26;
  context.lineWidth = 1.5;
  context.strokeStyle = palette.ink;
  context.fillStyle = palette.ink;
  context.beginPath();
  context.moveTo(nx, y);
  context.lineTo(nx, y - 14);
  context.stroke();
  context.beginPath();
  context.moveTo(nx, y - 20);
  context.lineTo(nx + 4, y - 11);
  context.lineTo(nx - 4, y - 11);
  context.fill();
  context.textAlign = "left";
  context.textBaseline = "middle";
  write(context, "N", nx + 7, y - 9, palette.ink);
}
