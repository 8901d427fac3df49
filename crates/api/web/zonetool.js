// The tool that draws a zone. The zone becomes a file, or with the scope "control" an active zone.

import { byId, setText } from "./dom.js";
import { saveText } from "./exports.js";
import { drawCorners } from "./measure.js";
import { palette } from "./palette.js";
import { metresOf } from "./units.js";

const DIGITS = 6; // decimals of degrees: 0.1 m
const LEAST_CORNERS = 3;

/** @typedef {{ x: number, y: number }} Corner */

export class ZoneTool {
  title = "Draw a zone";
  hint = "Click its corners in turn; Enter takes the middle of the map.";
  /** @type {Corner[]} */
  points = [];

  /**
   * `frame()`: frame of the picture, with its position on Earth. `active`: the zones that operators have activated.
   * @param {() => Frame | undefined} frame @param {ActiveZones} active
   */
  constructor(frame, active) {
    this.frame = frame;
    this.active = active;
    byId("zone-activate").addEventListener("click", () => this.activate());
    byId("zone-form").addEventListener("submit", (event) => {
      event.preventDefault();
      this.save();
    });
    byId("zone-form").addEventListener("input", () => this.showLines());
  }

  /** @param {number} x @param {number} y */
  add(x, y) {
    this.points.push({ x, y });
    this.showLines();
  }

  undo() {
    this.points.pop();
    this.showLines();
  }

  clear() {
    this.points = [];
    this.showLines();
  }

  words() {
    const left = LEAST_CORNERS - this.points.length;
    return left > 0 ? `${left} more corner${left > 1 ? "s" : ""} needed` : `${this.points.length} corners`;
  }

  /** @param {Context} context @param {View} view */
  draw(context, view) {
    const places = this.points.map(({ x, y }) => view.toScreen(x, y));
    context.save();
    context.fillStyle = palette.selected;
    context.globalAlpha = 0.12;
    context.beginPath();
    places.forEach(([px, py], i) => (i ? context.lineTo(px, py) : context.moveTo(px, py)));
    context.fill();
    context.restore();
    drawCorners(context, places, true);
  }

  /** Name and heights as entered; metres above sea level, null without a limit. */
  typed() {
    const [floor_m, ceiling_m] = ["zone-floor", "zone-ceiling"].map((id) => metresOf(byId(id, HTMLInputElement).value));
    return { name: byId("zone-name", HTMLInputElement).value.trim() || "zone", floor_m, ceiling_m };
  }

  /** Error of the input, as text; "" if there is none. */
  fault() {
    const { floor_m, ceiling_m } = this.typed();
    if (this.points.length < LEAST_CORNERS) return "A zone has at least three corners: click them on the map.";
    if (crossesItself(this.points)) return "Its edges cross each other.";
    return floor_m !== null && ceiling_m !== null && floor_m >= ceiling_m ? "The ceiling is not above the floor." : "";
  }

  /** Configuration lines for the zone, updated while the operator types. */
  showLines() {
    const { name, floor_m, ceiling_m } = this.typed();
    const limits = Object.entries({ floor_m, ceiling_m });
    const lines = limits.map(([key, value]) => (value === null ? "" : `${key} = ${value.toFixed(1)}\n`)).join("");
    setText(byId("zone-lines"), `[[areas]]\nkind = "alert"\nfile = "${fileName(name)}"\n${lines}`);
    setText(byId("zone-fault"), "");
  }

  save() {
    const fault = this.fault();
    setText(byId("zone-fault"), fault);
    const frame = this.frame();
    if (fault || !frame) return;
    saveText(fileName(this.typed().name), "application/geo+json", `${JSON.stringify(this.geojson(frame), null, 2)}\n`);
  }

  async activate() {
    const name = byId("zone-name", HTMLInputElement).value.trim();
    const unnamed = name ? "" : "An active zone needs a name.";
    const fault = this.fault() || unnamed || (this.active.has(name) ? "A zone of this name is active: revoke it first." : "");
    setText(byId("zone-fault"), fault);
    const frame = this.frame();
    if (fault || !frame || !(await this.active.activate(name, this.geojson(frame)))) return;
    byId("zone-name", HTMLInputElement).value = "";
    this.clear();
  }

  /** @param {Frame} frame */
  geojson(frame) {
    const { name, floor_m, ceiling_m } = this.typed();
    return geojsonOf(name, floor_m, ceiling_m, this.ring(frame));
  }

  /** Corners in GeoJSON order: longitude first, counterclockwise, the first one repeated at the end. @param {Frame} frame */
  ring(frame) {
    const corners = area(this.points) < 0 ? this.points.toReversed() : this.points;
    const ring = corners.map(({ x, y }) => {
      const [lat, lng] = frame.toGeodetic(x, y);
      return [Number(lng.toFixed(DIGITS)), Number(lat.toFixed(DIGITS))];
    });
    return [...ring, ring[0]];
  }
}

/** @param {string} name @param {number | null} floor_m @param {number | null} ceiling_m @param {number[][]} ring */
const geojsonOf = (name, floor_m, ceiling_m, ring) => ({
  type: "FeatureCollection",
  features: [{ type: "Feature", properties: { name, floor_m, ceiling_m }, geometry: { type: "Polygon", coordinates: [ring] } }],
});

/** Letters, digits and hyphens of any language: safe in a path and in a TOML string. @param {string} name */
const fileName = (name) => `${name.replace(/[^\p{L}\p{N}]+/gu, "-").replace(/^-+|-+$/g, "").toLowerCase() || "zone"}.geojson`;

/** Twice the area, positive for counterclockwise corners. @param {Corner[]} points */
const area = (points) => points.reduce((sum, { x, y }, i) => {
  const next = points[(i + 1) % points.length];
  return sum + x * next.y - next.x * y;
}, 0);

/** @param {Corner} a @param {Corner} b @param {Corner} c */
const turn = (a, b, c) => Math.sign((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));

/** @param {Corner[]} points */
function crossesItself(points) {
  const edges = points.map((point, i) => [point, points[(i + 1) % points.length]]);
  return edges.some(([a, b], i) =>
    edges.slice(i + 2).some(([c, d]) => d !== a && turn(a, b, c) !== turn(a, b, d) && turn(c, d, a) !== turn(c, d, b)),
  );
}
