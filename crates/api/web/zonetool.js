// The tool that draws a zone. It only makes a file: a zone is in force once the site's configuration names it.

import { byId, setText } from "./dom.js";
import { saveText } from "./exports.js";
import { drawCorners } from "./measure.js";
import { palette } from "./palette.js";
import { metresOf } from "./units.js";

const DIGITS = 6; // decimals of degrees: 0.1 m
const LEAST_CORNERS = 3;

export class ZoneTool {
  title = "Draw a zone";
  hint = "Click its corners in turn; Enter takes the middle of the map.";
  points = []; // {x, y}

  /** `frame()`: frame of the picture, with its position on Earth. */
  constructor(frame) {
    this.frame = frame;
    byId("zone-form").addEventListener("submit", (event) => {
      event.preventDefault();
      this.save();
    });
    byId("zone-form").addEventListener("input", () => this.showLines());
  }

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
    const [floor_m, ceiling_m] = ["zone-floor", "zone-ceiling"].map((id) => metresOf(byId(id).value));
    return { name: byId("zone-name").value.trim() || "zone", floor_m, ceiling_m };
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
    const limits = Object.entries({ floor_m, ceiling_m }).filter(([, value]) => value !== null);
    const lines = limits.map(([key, value]) => `${key} = ${value.toFixed(1)}\n`).join("");
    setText(byId("zone-lines"), `[[areas]]\nkind = "alert"\nfile = "${fileName(name)}"\n${lines}`);
    setText(byId("zone-fault"), "");
  }

  save() {
    const fault = this.fault();
    setText(byId("zone-fault"), fault);
    if (fault) return;
    const { name, floor_m, ceiling_m } = this.typed();
    saveText(fileName(name), "application/geo+json", `${JSON.stringify(geojsonOf(name, floor_m, ceiling_m, this.ring()), null, 2)}\n`);
  }

  /** Corners in GeoJSON order: longitude first, counterclockwise, the first one repeated at the end. */
  ring() {
    const corners = area(this.points) < 0 ? this.points.toReversed() : this.points;
    const ring = corners.map(({ x, y }) => {
      const [lat, lng] = this.frame().toGeodetic(x, y);
      return [Number(lng.toFixed(DIGITS)), Number(lat.toFixed(DIGITS))];
    });
    return [...ring, ring[0]];
  }
}

const geojsonOf = (name, floor_m, ceiling_m, ring) => ({
  type: "FeatureCollection",
  features: [{ type: "Feature", properties: { name, floor_m, ceiling_m }, geometry: { type: "Polygon", coordinates: [ring] } }],
});

/** Letters, digits and hyphens of any language: safe in a path and in a TOML string. */
const fileName = (name) => `${name.replace(/[^\p{L}\p{N}]+/gu, "-").replace(/^-+|-+$/g, "").toLowerCase() || "zone"}.geojson`;

/** Twice the area, positive for counterclockwise corners. */
const area = (points) => points.reduce((sum, { x, y }, i) => {
  const next = points[(i + 1) % points.length];
  return sum + x * next.y - next.x * y;
}, 0);

const turn = (a, b, c) => Math.sign((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));

function crossesItself(points) {
  const edges = points.map((point, i) => [point, points[(i + 1) % points.length]]);
  return edges.some(([a, b], i) =>
    edges.slice(i + 2).some(([c, d]) => d !== a && turn(a, b, c) !== turn(a, b, d) && turn(c, d, a) !== turn(c, d, b)),
  );
}
