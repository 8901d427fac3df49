// The panel of layers, labels, colours, trails and units.

import { byId, element, find } from "./dom.js";
import { change, LAYERS, namesOf, settings, toggleLayer, TRAILS_S } from "./settings.js";
import { DISTANCES, HEIGHTS, SPEEDS } from "./units.js";

/**
 * A list: element id, options with their texts, current choice, and the effect of a choice.
 * @template {string | number} T
 * @param {string} id @param {[T, string][]} options @param {() => T} chosen @param {(value: T) => void} choose
 */
const list = (id, options, chosen, choose) => ({
  listen() {
    const node = byId(id, HTMLSelectElement);
    node.append(...options.map(([value, words]) => element("option", { value }, words)));
    node.addEventListener("change", () => choose(options[node.selectedIndex][0]));
  },
  show() {
    byId(id, HTMLSelectElement).value = String(chosen());
  },
});

const LISTS = [
  list("label-by", [["name", "short name"], ["number", "track number"], ["serial", "serial number"]], () => settings.labelBy, (labelBy) => change({ labelBy })),
  list("colour-by", [["source", "source"], ["height", "height"]], () => settings.colourBy, (colourBy) => change({ colourBy })),
  list("trail-length", TRAILS_S.map((seconds) => [seconds, seconds < 120 ? `${seconds} s` : `${seconds / 60} min`]), () => settings.trailS, (trailS) => change({ trailS })),
  list("unit-height", optionsOf(HEIGHTS), () => settings.units.height, (height) => change({ units: { ...settings.units, height } })),
  list("unit-speed", optionsOf(SPEEDS), () => settings.units.speed, (speed) => change({ units: { ...settings.units, speed } })),
  list("unit-distance", optionsOf(DISTANCES), () => settings.units.distance, (distance) => change({ units: { ...settings.units, distance } })),
];

/** @type {Layer[]} */
const FROM_SITE = ["base", "tiles"]; // offered if the site has them

/** @template {string} K @param {Record<K, [string, ...unknown[]]>} units @returns {[K, string][]} */
function optionsOf(units) {
  return namesOf(units).map((name) => [name, units[name][0]]);
}

export function listenForChoices() {
  for (const name of namesOf(LAYERS)) {
    const box = element("input", { type: "checkbox", name });
    box.addEventListener("change", () => toggleLayer(name));
    byId("layer-list").append(element("li", { hidden: FROM_SITE.includes(name) }, element("label", {}, box, LAYERS[name][0])));
  }
  for (const { listen } of LISTS) listen();
  const ground = byId("ground", HTMLInputElement);
  ground.addEventListener("change", () => change({ groundM: ground.value === "" ? null : Number(ground.value) }));
}

export function showChoices() {
  for (const name of namesOf(LAYERS)) boxOf(name).checked = settings.layers[name];
  for (const { show } of LISTS) show();
  byId("ground", HTMLInputElement).value = String(settings.groundM ?? "");
}

/** Hides a layer for which the service has no data. @param {Layer} name @param {boolean} isThere */
export function offerLayer(name, isThere) {
  itemOf(name).hidden = !isThere;
}

/** @param {Layer} name */
export const isOffered = (name) => !itemOf(name).hidden;

/** @param {Layer} name */
const boxOf = (name) => find(byId("layer-list"), `[name=${name}]`, HTMLInputElement);
/** @param {Layer} name */
const itemOf = (name) => find(byId("layer-list"), `li:has([name=${name}])`);
