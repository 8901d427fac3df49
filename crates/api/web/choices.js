// The panel of layers, labels, colours, trails and units.

import { byId, element } from "./dom.js";
import { change, LAYERS, settings, toggleLayer, TRAILS_S } from "./settings.js";
import { DISTANCES, HEIGHTS, SPEEDS } from "./units.js";

/** Lists: element id, options with their texts, current choice, and the effect of a choice. */
const LISTS = [
  ["label-by", [["name", "short name"], ["number", "track number"], ["serial", "serial number"]], () => settings.labelBy, (labelBy) => change({ labelBy })],
  ["colour-by", [["source", "source"], ["height", "height"]], () => settings.colourBy, (colourBy) => change({ colourBy })],
  ["trail-length", TRAILS_S.map((seconds) => [seconds, seconds < 120 ? `${seconds} s` : `${seconds / 60} min`]), () => settings.trailS, (seconds) => change({ trailS: Number(seconds) })],
  ["unit-height", optionsOf(HEIGHTS), () => settings.units.height, (height) => change({ units: { ...settings.units, height } })],
  ["unit-speed", optionsOf(SPEEDS), () => settings.units.speed, (speed) => change({ units: { ...settings.units, speed } })],
  ["unit-distance", optionsOf(DISTANCES), () => settings.units.distance, (distance) => change({ units: { ...settings.units, distance } })],
];

const FROM_SITE = ["base", "tiles"]; // offered if the site has them

function optionsOf(units) {
  return Object.entries(units).map(([name, [words]]) => [name, words]);
}

export function listenForChoices() {
  for (const [name, [words]] of Object.entries(LAYERS)) {
    const box = element("input", { type: "checkbox", name });
    box.addEventListener("change", () => toggleLayer(name));
    byId("layer-list").append(element("li", { hidden: FROM_SITE.includes(name) }, element("label", {}, box, words)));
  }
  for (const [id, options, , choose] of LISTS) {
    byId(id).append(...options.map(([value, words]) => element("option", { value }, words)));
    byId(id).addEventListener("change", (event) => choose(event.target.value));
  }
  byId("ground").addEventListener("change", ({ target: { value } }) => change({ groundM: value === "" ? null : Number(value) }));
}

export function showChoices() {
  for (const box of byId("layer-list").querySelectorAll("input")) box.checked = settings.layers[box.name];
  for (const [id, , chosen] of LISTS) byId(id).value = String(chosen());
  byId("ground").value = settings.groundM ?? "";
}

/** Hides a layer for which the service has no data. */
export function offerLayer(name, isThere) {
  itemOf(name).hidden = !isThere;
}

export const isOffered = (name) => !itemOf(name).hidden;

const itemOf = (name) => byId("layer-list").querySelector(`[name=${name}]`).closest("li");
