// Images of symbols, drawn once and copied often: a copy is cheaper than a path with a halo.

import { contextOf } from "./dom.js";

const MOST = 500;

export class Sprites {
  /** @type {Map<string, HTMLCanvasElement>} */
  known = new Map();
  ratio = 1; // screen pixels per page pixel

  /** Removes all images after a change of theme or screen. */
  clear() {
    this.known.clear();
    this.ratio = window.devicePixelRatio || 1;
  }

  /**
   * Copies to (px, py) the image that `draw(context)` draws about the origin within `radius`.
   * @param {Context} context @param {string} key @param {number} radius @param {number} px @param {number} py
   * @param {(context: Context) => void} draw
   */
  put(context, key, radius, px, py, draw) {
    let sprite = this.known.get(key);
    if (!sprite) {
      if (this.known.size >= MOST) this.clear();
      this.known.set(key, (sprite = picture(radius, this.ratio, draw)));
    }
    // On whole pixels; elsewhere the copy would be blurred and slower.
    const { ratio } = this;
    const side = sprite.width / ratio;
    const [left, top] = [Math.round((px - side / 2) * ratio) / ratio, Math.round((py - side / 2) * ratio) / ratio];
    context.drawImage(sprite, left, top, side, side);
  }
}

/** @param {number} radius @param {number} ratio @param {(context: Context) => void} draw */
function picture(radius, ratio, draw) {
  const sprite = document.createElement("canvas");
  sprite.width = sprite.height = 2 * Math.ceil(radius * ratio);
  const context = contextOf(sprite);
  context.scale(ratio, ratio);
  context.translate(sprite.width / ratio / 2, sprite.height / ratio / 2);
  draw(context);
  return sprite;
}
