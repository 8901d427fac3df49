// Legend of all visible marks of the map, in their colours.

import { isOffered } from "./choices.js";
import { byId, element } from "./dom.js";
import { bands } from "./heights.js";
import { palette } from "./palette.js";
import { settings } from "./settings.js";
import { heightWords } from "./units.js";

const SVG = "http://www.w3.org/2000/svg";

/** A mark of 16 pixels. @param {...MarkShape} shapes */
function mark(...shapes) {
  const svg = document.createElementNS(SVG, "svg");
  svg.setAttribute("viewBox", "-8 -8 16 16");
  svg.setAttribute("aria-hidden", "true");
  for (const [tag, look, attributes] of shapes) {
    const shape = document.createElementNS(SVG, tag);
    shape.setAttribute("class", look);
    for (const [name, value] of Object.entries(attributes)) shape.setAttribute(name, String(value));
    svg.append(shape);
  }
  return svg;
}

const TRIANGLE = { d: "M0-6 6 5H-6Z" };
const LINE = { d: "M-7 5 7-5" };

/**
 * A shape of a mark: a tag, its style class, and its attributes.
 * @typedef {[string, string, Record<string, string | number>]} MarkShape
 */

/** Entries, with the layer they belong to, if any. @type {[Layer | null, MarkShape[], string][]} */
const ENTRIES = [
  [null, [["path", "radar", TRIANGLE]], "radar only: unidentified"],
  [null, [["circle", "fused", { r: 5 }]], "fused: radar and transponder"],
  [null, [["path", "transponder", { d: "M0-6.5 6.5 0 0 6.5-6.5 0Z" }]], "transponder only"],
  [null, [["rect", "camera", { x: -5, y: -5, width: 10, height: 10 }]], "cameras only: unidentified"],
  [null, [["path", "transponder", { d: "M0-7 1-2.5 6.5 1V2.5L1 1 .7 4.5 2.5 6V7L0 6-2.5 7V6L-.7 4.5-1 1-6.5 2.5V1L-1-2.5Z" }]], "crewed aircraft; the colour is that of the source"],
  [null, [["path", "radar hollow", TRIANGLE]], "unlikely to be a drone (radar)"],
  [null, [["circle", "coasting", { r: 5 }]], "not measured, extrapolated"],
  [null, [["circle", "doubted", { r: 6 }]], "transponder not to be trusted"],
  [null, [["circle", "alarmed", { r: 6 }]], "has an alert"],
  [null, [["circle", "watched", { r: 6 }]], "on the watch list"],
  [null, [["path", "chosen", { d: "M-7-3V-7H-3M3-7H7V-3M7 3V7H3M-3 7H-7V3" }]], "selected"],
  [null, [["path", "alarmed", LINE]], "path to the closest approach of two aircraft"],
  ["trails", [["path", "trail", LINE]], "trail, fading with age"],
  ["vectors", [["path", "vector", LINE]], "predicted path, 10 s"],
  ["ellipses", [["ellipse", "ellipse", { rx: 7, ry: 4 }]], "uncertainty, 95 %"],
  ["coverage", [["path", "coverage", LINE]], "a sensor's coverage"],
  ["areas", [["rect", "area", { x: -6, y: -5, width: 12, height: 10 }]], "zone; red: critical; dashed: not in force now"],
  ["cells", [["path", "cells", LINE]], "cell of the cluster, with its owner"],
  ["base", [["rect", "base", { x: -6, y: -5, width: 12, height: 10 }]], "base map: water, woods and fields, roads, buildings"],
  ["raw", [["path", "radar-line", { d: "M-3-3 3 3M-3 3 3-3" }]], "radar plot"],
  ["raw", [["rect", "transponder-line", { x: -3, y: -3, width: 6, height: 6 }]], "transponder report"],
];

/** Unchanged until a layer, a colour or a unit changes. */
export function showLegend() {
  const shown = ENTRIES.filter(([layer]) => layer === null || (settings.layers[layer] && isOffered(layer)));
  const items = shown.map(([, shapes, words]) => element("li", {}, mark(...shapes), words));
  if (settings.layers.labels) items.push(element("li", {}, element("span", { class: "sample" }, "124↑ 15"), `height, climbing, ${settings.units.speed}`));
  items.push(element("li", {}, `Heights: ${heightWords()}`));
  if (settings.colourBy === "height") {
    for (const [band, words] of bands()) {
      const swatch = mark(["circle", "", { r: 5, fill: palette[band] }]);
      items.push(element("li", {}, swatch, words));
    }
  }
  byId("legend-list").replaceChildren(...items);
}
