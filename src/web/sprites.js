// Small pictures that are drawn once and put down often: a symbol costs a copy, not a path with a halo.

const MOST = 500;
const ratio = () => window.devicePixelRatio || 1;

export class Sprites {
  known = new Map();

  /** After another theme, or on another screen. */
  clear() {
    this.known.clear();
  }

  /** Puts down, about (px, py), what `draw(context)` draws about the origin within `radius`. */
  put(context, key, radius, px, py, draw) {
    let sprite = this.known.get(key);
    if (!sprite) {
      if (this.known.size >= MOST) this.clear();
      this.known.set(key, (sprite = picture(radius, draw)));
    }
    // On whole pixels: elsewhere it would be blurred, and slower.
    const side = sprite.width / ratio();
    const whole = (value) => Math.round((value - side / 2) * ratio()) / ratio();
    context.drawImage(sprite, whole(px), whole(py), side, side);
  }
}

function picture(radius, draw) {
  const sprite = document.createElement("canvas");
  sprite.width = sprite.height = 2 * Math.ceil(radius * ratio());
  const context = sprite.getContext("2d");
  context.scale(ratio(), ratio());
  context.translate(sprite.width / ratio() / 2, sprite.height / ratio() / 2);
  draw(context);
  return sprite;
}
