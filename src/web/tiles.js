// The user's own map tiles under everything, where the service is configured with some: the only pictures from elsewhere.

import { palette } from "./palette.js";

const TILE_PX = 256;
const EQUATOR_M = 2 * Math.PI * 6378137;
const DEEPEST = 19;
const MOST = 100; // in sight at once; a view that needs more gets coarser ones
const KEPT = 300;
const MANY_MISSING = 4;

export class Tiles {
  pictures = new Map(); // by address, the one used last at the end
  missing = 0; // since the last one that came

  /** `came` is told whether the latest tiles come: one that is missing at the edge of a set of tiles is no failure. */
  constructor({ url, attribution = "" }, frame, came) {
    Object.assign(this, { url, attribution, frame, came });
  }

  draw(context, view) {
    const corners = [[0, 0], [view.width, 0], [0, view.height], [view.width, view.height]];
    const places = corners.map(([px, py]) => mercator(...this.frame.toGeodetic(...view.toLocal(px, py))));
    const [left, right] = [Math.min(...places.map(([x]) => x)), Math.max(...places.map(([x]) => x))];
    const [top, bottom] = [Math.min(...places.map(([, y]) => y)), Math.max(...places.map(([, y]) => y))];
    const pixels = (EQUATOR_M * Math.cos((this.frame.lat * Math.PI) / 180) * view.scale) / TILE_PX;
    let zoom = Math.max(0, Math.min(DEEPEST, Math.round(Math.log2(pixels))));
    const across = (least, most) => Math.floor(most * 2 ** zoom) - Math.floor(least * 2 ** zoom) + 1;
    while (zoom > 0 && across(left, right) * across(top, bottom) > MOST) zoom -= 1;
    const n = 2 ** zoom;
    context.save();
    context.globalAlpha = palette.isDark ? 0.45 : 0.8; // tracks and labels stay above it
    for (let x = Math.floor(left * n); x <= Math.floor(right * n); x++) {
      for (let y = Math.max(0, Math.floor(top * n)); y <= Math.min(n - 1, Math.floor(bottom * n)); y++) {
        this.drawOne(context, view, zoom, x, y);
      }
    }
    context.restore();
    this.forget();
  }

  /** A tile is small enough for its bend in the local frame not to be seen: three corners place it. */
  drawOne(context, view, zoom, x, y) {
    const n = 2 ** zoom;
    const picture = this.picture(zoom, ((x % n) + n) % n, y);
    if (!picture.complete || !picture.naturalWidth) return;
    const corner = (i, j) => view.toScreen(...this.frame.toLocal(...geodetic((x + i) / n, (y + j) / n)));
    const [[px, py], [rx, ry], [bx, by]] = [corner(0, 0), corner(1, 0), corner(0, 1)];
    const { naturalWidth: w, naturalHeight: h } = picture;
    context.save();
    context.transform((rx - px) / w, (ry - py) / w, (bx - px) / h, (by - py) / h, px, py);
    context.drawImage(picture, 0, 0, w + 0.5, h + 0.5); // half a pixel more: no seams
    context.restore();
  }

  picture(zoom, x, y) {
    const address = this.url.replace("{z}", zoom).replace("{x}", x).replace("{y}", y);
    let picture = this.pictures.get(address);
    if (!picture) {
      picture = new Image();
      picture.referrerPolicy = "no-referrer";
      picture.addEventListener("load", () => this.note(0));
      picture.addEventListener("error", () => this.note(this.missing + 1));
      picture.src = address;
    }
    this.pictures.delete(address);
    this.pictures.set(address, picture);
    return picture;
  }

  note(missing) {
    this.missing = missing;
    this.came(missing < MANY_MISSING);
  }

  forget() {
    for (const address of this.pictures.keys()) {
      if (this.pictures.size <= KEPT) return;
      this.pictures.delete(address);
    }
  }
}

/** Across and down the square of Web Mercator, 0 to 1. */
function mercator(lat, lng) {
  const sin = Math.sin((Math.max(-85, Math.min(85, lat)) * Math.PI) / 180);
  return [lng / 360 + 0.5, 0.5 - Math.atanh(sin) / (2 * Math.PI)];
}

const geodetic = (x, y) => [(Math.atan(Math.sinh(Math.PI * (1 - 2 * y))) * 180) / Math.PI, (x - 0.5) * 360];
