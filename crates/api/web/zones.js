// Configured areas on the map: style by type and by whether they are in force, with heights beside their names.

import { palette } from "./palette.js";
import { Shapes } from "./shapes.js";
import { height } from "./units.js";

/**
 * @typedef {{ colour: Colour, fill: number, dash?: number[] }} Look
 * @type {Record<"critical" | "alert" | "idle" | "mask", Look>}
 */
const LOOKS = {
  critical: { colour: "critical", fill: 0.1 },
  alert: { colour: "area", fill: 0.08 },
  idle: { colour: "area", fill: 0, dash: [2, 5] }, // not in force at this time
  mask: { colour: "quiet", fill: 0.05, dash: [8, 3] }, // plots inside are dropped
};

/** @param {AreaProperties} area */
function lookOf({ kind, type, severity, active }) {
  if (kind === "mask") return "mask";
  if (active === false) return "idle";
  return severity === "critical" || type === "prohibited" ? "critical" : "alert";
}

export class Zones {
  /**
   * Takes the answer of /areas. Coverage areas are drawn with the coverage, not here.
   * @param {AreasAnswer} geojson @param {Frame} frame
   */
  constructor(geojson, frame) {
    this.geojson = geojson;
    const zones = geojson.features.filter(({ properties }) => properties.kind !== "coverage");
    this.parts = [...Map.groupBy(zones, ({ properties }) => lookOf(properties))].map(([look, features]) => ({
      ...LOOKS[look],
      shapes: new Shapes(look, { type: "FeatureCollection", features: features.map(named) }, frame),
    }));
  }

  /** The same areas in another frame. @param {Frame} frame */
  in(frame) {
    return new Zones(this.geojson, frame);
  }

  /** @param {Context} context @param {View} view */
  draw(context, view) {
    for (const { colour, fill, dash, shapes } of this.parts) shapes.draw(context, view, palette[colour], { fill, dash });
  }
}

/** Name with heights: "School, 0 to 120 m". @param {AreasAnswer["features"][number]} feature */
function named(feature) {
  const { name = "", floor_m, ceiling_m } = feature.properties;
  const limits = [floor_m == null ? "" : `from ${height(floor_m)}`, ceiling_m == null ? "" : `to ${height(ceiling_m)}`].filter(Boolean).join(" ");
  return { ...feature, properties: { name: [name, limits].filter(Boolean).join(", ") } };
}
