// Visible part of the world, and its control by the pointer: drag, wheel, pinch, click.

import { FreeSpace } from "./freespace.js";

const [SMALLEST, LARGEST] = [0.001, 50]; // pixels per metre
const MARGIN_PX = 100;
const [FEW, FAR, LEAST_M] = [4, 4, 200]; // from that many places, those beyond four times the median distance are outliers
const LEAST_VIEW_M = 1500; // minimum width and height of the first view
const CLICK_PX = 5; // a finger always moves a little

export class View {
  x = 0; // centre, in metres
  y = 0;
  scale = 0.1; // pixels per metre
  width = 1;
  height = 1;
  space = new FreeSpace(1, 1, []); // for text, renewed at each frame

  /** @param {number} x @param {number} y @returns {Point} */
  toScreen(x, y) {
    return [this.width / 2 + (x - this.x) * this.scale, this.height / 2 - (y - this.y) * this.scale];
  }

  /** @param {number} px @param {number} py @returns {Point} */
  toLocal(px, py) {
    return [this.x + (px - this.width / 2) / this.scale, this.y - (py - this.height / 2) / this.scale];
  }

  /** @param {number} px @param {number} py @param {number} [margin] */
  contains(px, py, margin = 0) {
    return px >= -margin && py >= -margin && px <= this.width + margin && py <= this.height + margin;
  }

  /** @param {number} scale */
  setScale(scale) {
    this.scale = Math.min(LARGEST, Math.max(SMALLEST, scale));
  }

  /** Zooms; the place under the pointer stays there. @param {number} px @param {number} py @param {number} factor */
  zoomAt(px, py, factor) {
    const [x, y] = this.toLocal(px, py);
    this.setScale(this.scale * factor);
    const [nowX, nowY] = this.toLocal(px, py);
    this.x += x - nowX;
    this.y += y - nowY;
  }

  /** @param {number} dx @param {number} dy */
  pan(dx, dy) {
    this.x -= dx / this.scale;
    this.y += dy / this.scale;
  }

  /** Fits the places that are near most others: an outlier does not set the scale. @param {Point[]} places */
  fitMost(places) {
    if (places.length < FEW) return this.fit(places, LEAST_VIEW_M);
    /** @param {number[]} values */
    const median = (values) => values.sort((a, b) => a - b)[Math.floor(values.length / 2)];
    const [x, y] = [0, 1].map((axis) => median(places.map((place) => place[axis])));
    /** @param {Point} place */
    const apart = ([px, py]) => Math.hypot(px - x, py - y);
    const usual = median(places.map(apart));
    this.fit(places.filter((place) => apart(place) <= Math.max(LEAST_M, FAR * usual)), LEAST_VIEW_M);
  }

  /**
   * Fits all places, [x, y] each, with a margin that is smaller on a phone. The view is at least `least` metres wide and high.
   * @param {Point[]} places @param {number} [least]
   */
  fit(places, least = 200) {
    if (!places.length) return;
    const margin = Math.min(MARGIN_PX, Math.min(this.width, this.height) / 8);
    let [left, right, bottom, top] = [Infinity, -Infinity, Infinity, -Infinity];
    for (const [x, y] of places) {
      [left, right] = [Math.min(left, x), Math.max(right, x)];
      [bottom, top] = [Math.min(bottom, y), Math.max(top, y)];
    }
    this.x = (left + right) / 2;
    this.y = (bottom + top) / 2;
    const wide = Math.max(100, this.width - 2 * margin) / Math.max(right - left, least);
    const high = Math.max(100, this.height - 2 * margin) / Math.max(top - bottom, least);
    this.setScale(Math.min(wide, high));
  }
}

/**
 * Callbacks: `on.moved(isPan)`, `on.clicked(px, py)`, and `on.hovered(px, py)`, or `on.hovered()` when the pointer has left.
 * @param {HTMLCanvasElement} canvas @param {View} view @param {Steering} on
 */
export function steer(canvas, view, on) {
  const pointers = new Map();
  let travelled = 0;
  /** @param {MouseEvent} event @returns {Point} */
  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  const pair = () => {
    const [[ax, ay], [bx, by]] = [...pointers.values()];
    return { x: (ax + bx) / 2, y: (ay + by) / 2, apart: Math.hypot(ax - bx, ay - by) };
  };

  canvas.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    canvas.setPointerCapture(event.pointerId);
    if (!pointers.size) travelled = 0;
    pointers.set(event.pointerId, place(event));
  });
  canvas.addEventListener("pointermove", (event) => {
    const to = place(event);
    on.hovered(...to);
    const from = pointers.get(event.pointerId);
    if (!from) return;
    const before = pointers.size === 2 ? pair() : null;
    pointers.set(event.pointerId, to);
    travelled += Math.hypot(to[0] - from[0], to[1] - from[1]);
    if (travelled < CLICK_PX) return;
    if (before) {
      const now = pair();
      view.pan(now.x - before.x, now.y - before.y);
      if (before.apart > 0) view.zoomAt(now.x, now.y, now.apart / before.apart);
    } else if (pointers.size === 1) {
      view.pan(to[0] - from[0], to[1] - from[1]);
    }
    on.moved(true);
  });
  /** @param {PointerEvent} event */
  const up = (event) => {
    if (!pointers.delete(event.pointerId)) return;
    if (event.type === "pointerup" && travelled < CLICK_PX) on.clicked(...place(event));
  };
  canvas.addEventListener("pointerup", up);
  canvas.addEventListener("pointercancel", up);
  canvas.addEventListener("pointerleave", () => on.hovered());
  canvas.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      const pixels = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 20 : 1);
      view.zoomAt(...place(event), 2 ** (-pixels / 300));
      on.moved(false);
    },
    { passive: false },
  );
}
