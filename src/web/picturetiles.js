// Map tiles that are pictures, of a server of the site's choice: the only ones from elsewhere.

import { palette } from "./palette.js";

const KEPT = 300;
const MANY_MISSING = 4;

export class PictureTiles {
  tilePx = 256;
  pictures = new Map(); // by address, the one used last at the end
  missing = 0; // since the last one that came

  /** `came` is told whether the latest tiles come: one that is missing at the edge of a set of tiles is no failure. */
  constructor({ url }, came) {
    Object.assign(this, { url, came });
  }

  alpha() {
    return palette.isDark ? 0.45 : 0.8;
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
    if (this.pictures.size > KEPT) this.pictures.delete(this.pictures.keys().next().value);
    return picture.complete && picture.naturalWidth ? picture : null;
  }

  note(missing) {
    this.missing = missing;
    this.came(missing < MANY_MISSING, "their server does not send them");
  }
}
