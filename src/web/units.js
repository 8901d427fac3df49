// Heights, speeds and distances in the units that the operator chose. What the service says is metres and metres a second.

import { grouped, THIN } from "./format.js";
import { settings } from "./settings.js";

const FOOT_M = 0.3048;
const KNOT = 1852 / 3600; // metres a second
const MILE_M = 1852;

/** Of each unit of height: its words in the list, what stands beside a value, and metres above sea level as its number. */
export const HEIGHTS = {
  m: ["m above sea level", "m", (metres) => metres],
  ft: ["ft above sea level", "ft", (metres) => metres / FOOT_M],
  FL: ["flight level (standard pressure)", "FL", (metres) => metres / FOOT_M / 100],
  "m-agl": ["m above the ground stated below", "m AGL", (metres) => metres - settings.groundM],
  "ft-agl": ["ft above the ground stated below", "ft AGL", (metres) => (metres - settings.groundM) / FOOT_M],
};

/** The same of speeds over ground, of metres a second. */
export const SPEEDS = {
  "m/s": ["m/s", "m/s", (value) => value],
  kt: ["knots", "kt", (value) => value / KNOT],
  "km/h": ["km/h", "km/h", (value) => value * 3.6],
};

/** And of distances: the unit, and that of long ones, with what they are in metres. */
export const DISTANCES = {
  m: ["m and km", ["m", 1], ["km", 1000]],
  nm: ["ft and nautical miles", ["ft", FOOT_M], ["NM", MILE_M]],
};

/** Above the ground only where the operator has stated it: else above sea level. */
export const heightUnit = () =>
  settings.units.height.endsWith("-agl") && settings.groundM === null ? settings.units.height.replace("-agl", "") : settings.units.height;

/** Metres above sea level as a number without its unit; "–" where it is not known. */
export function plainHeight(metres, digits = 0) {
  if (!Number.isFinite(metres)) return "–";
  const unit = heightUnit();
  const value = HEIGHTS[unit][2](metres);
  return unit === "FL" ? String(Math.max(0, Math.round(value))).padStart(3, "0") : grouped(value, digits);
}

/** With its unit: "124 m", "FL004". */
export function height(metres, digits = 0) {
  if (!Number.isFinite(metres)) return "–";
  const unit = heightUnit();
  return unit === "FL" ? `FL${plainHeight(metres)}` : `${plainHeight(metres, digits)}${THIN}${HEIGHTS[unit][1]}`;
}

/** Above what heights are, as the heading of one. */
export const heightName = () => (heightUnit() === "FL" ? "Flight level (standard pressure)" : heightUnit().endsWith("-agl") ? "Height above ground" : "Height AMSL");

export const heightWords = () => HEIGHTS[heightUnit()][0];

/** What the operator typed in the unit in force as metres above sea level; null where it is no number. */
export function metresOf(text) {
  const value = text.trim() === "" ? NaN : Number(text);
  if (!Number.isFinite(value)) return null;
  const [, , of] = HEIGHTS[heightUnit()];
  return (value - of(0)) / (of(1) - of(0));
}

export const plainSpeed = (value) => (Number.isFinite(value) ? grouped(SPEEDS[settings.units.speed][2](value)) : "–");

export const speed = (value, digits = 0) =>
  Number.isFinite(value) ? `${grouped(SPEEDS[settings.units.speed][2](value), digits)}${THIN}${settings.units.speed}` : "–";

const LONG = 10; // of the long unit from here on

export function distance(metres) {
  if (!Number.isFinite(metres)) return "–";
  const [, [short, shortM], [long, longM]] = DISTANCES[settings.units.distance];
  return metres < LONG * longM && !(long === "NM" && metres >= longM)
    ? `${grouped(metres / shortM)}${THIN}${short}`
    : `${(metres / longM).toFixed(1)}${THIN}${long}`;
}

/** The round number (1, 2 or 5 of a power of ten, of the unit that it is shown in) that is at least `least`; metres. */
export function roundDistance(least) {
  const [, [, shortM], [long, longM]] = DISTANCES[settings.units.distance];
  const unit = least >= (long === "NM" ? longM / 2 : longM) ? longM : shortM;
  const power = 10 ** Math.floor(Math.log10(least / unit));
  return [1, 2, 5, 10].map((digit) => digit * power).find((value) => value >= (least / unit) * 0.999) * unit;
}

/** The unit of a column of distances, and a distance in it. */
export const distanceUnit = () => (settings.units.distance === "nm" ? "NM" : "m");
export const plainDistance = (metres) => {
  if (!Number.isFinite(metres)) return "–";
  return settings.units.distance === "nm" ? (metres / MILE_M).toFixed(2) : grouped(metres);
};

/** Up or down, beside heights in metres or in feet. */
export const climb = (value) =>
  heightUnit().startsWith("m") ? `${grouped(value, 1)}${THIN}m/s` : `${grouped((value / FOOT_M) * 60)}${THIN}ft/min`;

const LEVEL = 0.5; // metres a second: less is not climbing

/** "↑" while it climbs, "↓" while it sinks, "" where it does neither or that is not known. */
export const climbArrow = ({ properties: { vertical_speed: value } }) => (value > LEVEL ? "↑" : value < -LEVEL ? "↓" : "");
