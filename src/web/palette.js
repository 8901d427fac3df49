// The colours of the style sheet for the canvas, which knows nothing of custom properties or of light and dark.

import { settings } from "./settings.js";

const NAMES = [
  "map", "ink", "quiet", "line", "halo", "fused", "radar", "transponder", "selected", "area", "coverage", "overlay",
  "warning", "critical",
];

export const palette = {};

const probe = document.createElement("span");
probe.hidden = true;

/** The theme on the document, and the colours that follow from it. */
export function applyTheme() {
  document.documentElement.dataset.theme = settings.theme;
  if (!probe.isConnected) document.body.append(probe);
  for (const name of NAMES) {
    probe.style.color = `var(--${name})`;
    palette[name] = getComputedStyle(probe).color;
  }
  palette.isDark = theme() === "dark";
}

const theme = () =>
  settings.theme !== "auto" ? settings.theme : matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";

const NEXT = { auto: "light", light: "dark", dark: "auto" };
export const nextTheme = () => NEXT[settings.theme];
