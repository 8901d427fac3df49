// Layer of raw inputs: plots and transponder reports as received, each shown when the picture reaches its time, so that it
// appears beside its track. They are requested only while the layer is on.

import { get, list } from "./api.js";
import { palette } from "./palette.js";
import { settings } from "./settings.js";

const AHEAD_MS = 30000; // the picture is 6.25 s behind the inputs; later ones are from another time of a replay
const SHOWN_MS = 5000;
const MOST = 40000;

export class Raw {
  /** @type {{ time: number, x: number, y: number, kind: "radar" | "transponder" }[]} */
  reports = [];
  last = 0;

  /** @param {Map2d} map */
  constructor(map) {
    this.map = map;
  }

  /** Whether the layer is on. If not, the reports are removed. */
  get isWanted() {
    const isWanted = settings.layers.raw && this.map.picture !== null && !document.hidden;
    if (!isWanted) this.reports = [];
    return isWanted;
  }

  ask() {
    return get(`raw?after=${this.last}`);
  }

  /** Takes the answer of /raw. @param {RawAnswer} collection */
  take(collection) {
    const features = list(collection, "features");
    this.last = collection.last ?? 0;
    if (!this.map.picture) return;
    const { frame, time: now } = this.map.picture;
    for (const { geometry, properties } of features) {
      const [lng, lat] = geometry.coordinates;
      const [x, y] = frame.toLocal(lat, lng);
      this.reports.push({ time: Date.parse(properties.time), x, y, kind: properties.kind });
    }
    this.reports = this.reports.filter(({ time }) => time > now - SHOWN_MS && time < now + AHEAD_MS).slice(-MOST);
    this.map.invalidate();
  }

  /** Moves each report to `to(x, y)`. @param {Move} to */
  move(to) {
    for (const report of this.reports) [report.x, report.y] = to(report.x, report.y);
  }

  /**
   * Small crosses for radar and small squares for transponders, fading with age, distinct from track symbols.
   * @param {Context} context @param {View} view @param {number} now
   */
  draw(context, view, now) {
    context.save();
    context.lineWidth = 1;
    for (const kind of /** @type {const} */ (["radar", "transponder"])) {
      context.strokeStyle = palette[kind];
      for (const isOld of [true, false]) {
        context.globalAlpha = isOld ? 0.45 : 0.9;
        context.beginPath();
        for (const report of this.reports) {
          const age = now - report.time;
          if (report.kind !== kind || age < 0 || age > SHOWN_MS || age > SHOWN_MS / 3 !== isOld) continue;
          const [px, py] = view.toScreen(report.x, report.y);
          if (view.contains(px, py)) mark(context, kind, px, py);
        }
        context.stroke();
      }
    }
    context.restore();
  }
}

/** @param {Context} context @param {string} kind @param {number} px @param {number} py */
function mark(context, kind, px, py) {
  if (kind === "transponder") {
    context.rect(px - 3, py - 3, 6, 6);
  } else {
    context.moveTo(px - 2.5, py - 2.5);
    context.lineTo(px + 2.5, py + 2.5);
    context.moveTo(px - 2.5, py + 2.5);
    context.lineTo(px + 2.5, py - 2.5);
  }
}
