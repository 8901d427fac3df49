// Map tiles (Web Mercator) below everything: visible tiles and their positions in the local frame.

import { FONT, writeFree } from "./fixtures.js";

const EQUATOR_M = 2 * Math.PI * 6378137;
const DEEPEST = 19;
const MOST = 100; // maximum number of visible tiles; a view that needs more gets coarser ones

/**
 * Layer of a source: `source.picture(zoom, x, y)` returns the image of a tile, or null; `source.tilePx` is its size,
 * `source.alpha()` its opacity.
 * @template {TileSource} Source
 */
export class Tiles {
  /** @param {Source} source @param {Frame} frame */
  constructor(source, frame) {
    this.source = source;
    this.frame = frame;
  }

  /** @param {Context} context @param {View} view */
  draw(context, view) {
    const { zoom, left, right, top, bottom } = this.inSight(view);
    context.save();
    context.globalAlpha = this.source.alpha(); // tracks and labels stay readable
    for (let x = left; x <= right; x++) {
      for (let y = top; y <= bottom; y++) this.drawOne(context, view, zoom, x, y);
    }
    context.restore();
  }

  /** The highest zoom suitable for the view, and its visible tiles. @param {View} view */
  inSight(view) {
    const corners = [[0, 0], [view.width, 0], [0, view.height], [view.width, view.height]];
    const places = corners.map(([px, py]) => mercator(...this.frame.toGeodetic(...view.toLocal(px, py))));
    const [xs, ys] = [places.map(([x]) => x), places.map(([, y]) => y)];
    const pixels = (EQUATOR_M * Math.cos((this.frame.lat * Math.PI) / 180) * view.scale) / this.source.tilePx;
    let zoom = Math.max(0, Math.min(DEEPEST, Math.round(Math.log2(pixels))));
    /** @param {number[]} values */
    const across = (values) => Math.floor(Math.max(...values) * 2 ** zoom) - Math.floor(Math.min(...values) * 2 ** zoom) + 1;
    while (zoom > 0 && across(xs) * across(ys) > MOST) zoom -= 1;
    const n = 2 ** zoom;
    return {
      zoom,
      left: Math.floor(Math.min(...xs) * n),
      right: Math.floor(Math.max(...xs) * n),
      top: Math.max(0, Math.floor(Math.min(...ys) * n)),
      bottom: Math.min(n - 1, Math.floor(Math.max(...ys) * n)),
    };
  }

  /**
   * Names of places where space is free, most important first.
   * @this {Tiles<VectorTiles>} @param {Context} context @param {View} view
   */
  drawNames(context, view) {
    const { zoom: wanted, ...sight } = this.inSight(view);
    const zoom = Math.min(wanted, this.source.deepest);
    const above = wanted - zoom;
    /** @type {[number, string, Point][]} */
    const names = [];
    for (let x = sight.left >> above; x <= sight.right >> above; x++) {
      for (let y = sight.top >> above; y <= sight.bottom >> above; y++) {
        for (const [name, rank, i, j] of this.source.names(zoom, x, y)) names.push([rank, name, this.place(view, zoom, x + i, y + j)]);
      }
    }
    context.font = FONT;
    context.textAlign = "center";
    context.textBaseline = "middle";
    for (const [, name, [px, py]] of names.sort(([a], [b]) => a - b)) writeFree(context, view, name, px, py);
  }

  /**
   * The curvature within a tile is invisible in the local frame, so three corners position it.
   * @param {Context} context @param {View} view @param {number} zoom @param {number} x @param {number} y
   */
  drawOne(context, view, zoom, x, y) {
    const n = 2 ** zoom;
    const picture = this.source.picture(zoom, ((x % n) + n) % n, y);
    if (!picture) return;
    const [[px, py], [rx, ry], [bx, by]] = [[0, 0], [1, 0], [0, 1]].map(([i, j]) => this.place(view, zoom, x + i, y + j));
    const [w, h] = picture instanceof HTMLImageElement ? [picture.naturalWidth, picture.naturalHeight] : [picture.width, picture.height];
    context.save();
    context.transform((rx - px) / w, (ry - py) / w, (bx - px) / h, (by - py) / h, px, py);
    context.drawImage(picture, 0, 0, w + 0.5, h + 0.5); // half a pixel more, to avoid seams
    context.restore();
  }

  /**
   * Screen position of a place in tile coordinates of this zoom.
   * @param {View} view @param {number} zoom @param {number} x @param {number} y
   */
  place(view, zoom, x, y) {
    return view.toScreen(...this.frame.toLocal(...geodetic(x / 2 ** zoom, y / 2 ** zoom)));
  }
}

/** Coordinates in the square of Web Mercator, 0 to 1, to the right and down. @param {number} lat @param {number} lng */
function mercator(lat, lng) {
  const sin = Math.sin((Math.max(-85, Math.min(85, lat)) * Math.PI) / 180);
  return [lng / 360 + 0.5, 0.5 - Math.atanh(sin) / (2 * Math.PI)];
}

/** @param {number} x @param {number} y @returns {Point} */
const geodetic = (x, y) => [(Math.atan(Math.sinh(Math.PI * (1 - 2 * y))) * 180) / Math.PI, (x - 0.5) * 360];
