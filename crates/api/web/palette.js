// Colours of the style sheet for the canvas, which does not support custom properties or themes.

import { settings } from "./settings.js";

const NAMES = [
  "map", "ink", "quiet", "line", "halo", "fused", "radar", "transponder", "selected", "area", "coverage", "overlay",
  "warning", "critical", "band0", "band1", "band2", "band3", "band4", "band5",
  "map-green", "map-water", "map-building", "map-road", "map-border",
];

export const palette = {};

const probe = document.createElement("span");
probe.hidden = true;

/** Sets the theme of the document, and updates the colours. */
export function applyTheme(name = settings.theme) {
  document.documentElement.dataset.theme = name;
  if (!probe.isConnected) document.body.append(probe);
  for (const name of NAMES) {
    probe.style.color = `var(--${name})`;
    palette[name] = getComputedStyle(probe).color;
  }
  palette.isDark = isDark(name);
}

const isDark = (name) => (name === "auto" ? matchMedia("(prefers-color-scheme: dark)").matches : name === "dark");

const NEXT = { auto: "light", light: "dark", dark: "auto" };
export const nextTheme = () => NEXT[settings.theme];
