// Raster map tiles from a server chosen by the site, the only requests to another server.

import { palette } from "./palette.js";

const KEPT = 300;
const MANY_MISSING = 4;

export class PictureTiles {
  tilePx = 256;
  pictures = new Map(); // by URL, most recently used last
  missing = 0; // number of failures since the last success

  /**
   * `came` receives whether the latest tiles arrive. A single missing tile at the edge of a tile set is not a failure.
   * @param {{ url: string }} server @param {TilesCame} came
   */
  constructor({ url }, came) {
    this.url = url;
    this.came = came;
  }

  alpha() {
    return palette.isDark ? 0.45 : 0.8;
  }

  /** @param {number} zoom @param {number} x @param {number} y */
  picture(zoom, x, y) {
    const address = this.url.replace("{z}", String(zoom)).replace("{x}", String(x)).replace("{y}", String(y));
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
    if (this.pictures.size > KEPT) this.pictures.delete(this.pictures.keys().next().value);
    return picture.complete && picture.naturalWidth ? picture : null;
  }

  /** @param {number} missing */
  note(missing) {
    this.missing = missing;
    this.came(missing < MANY_MISSING, "their server does not send them");
  }
}
