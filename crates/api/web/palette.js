// Colours of the style sheet for the canvas, which does not support custom properties or themes.

import { settings } from "./settings.js";

const NAMES = /** @type {const} */ ([
  "map", "ink", "quiet", "line", "halo", "fused", "radar", "transponder", "camera", "selected", "area", "coverage", "overlay",
  "warning", "critical", "band0", "band1", "band2", "band3", "band4", "band5",
  "map-green", "map-wood", "map-farm", "map-built", "map-water", "map-building", "map-road", "map-border",
]);

/** @typedef {typeof NAMES[number]} Colour */

export const palette = /** @type {Record<Colour, string> & { isDark: boolean }} */ ({});

const probe = document.createElement("span");
probe.hidden = true;

/** Sets the theme of the document, and updates the colours. @param {Settings["theme"]} [name] */
export function applyTheme(name = settings.theme) {
  document.documentElement.dataset.theme = name;
  if (!probe.isConnected) document.body.append(probe);
  for (const name of NAMES) {
    probe.style.color = `var(--${name})`;
    palette[name] = getComputedStyle(probe).color;
  }
  palette.isDark = isDark(name);
}

/** @param {Settings["theme"]} name */
const isDark = (name) => (name === "auto" ? matchMedia("(prefers-color-scheme: dark)").matches : name === "dark");

/** @type {Record<Settings["theme"], Settings["theme"]>} */
const NEXT = { auto: "light", light: "dark", dark: "auto" };
export const nextTheme = () => NEXT[settings.theme];
