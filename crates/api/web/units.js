// Heights, speeds and distances in the selected units. The service uses metres and metres per second.

import { grouped, THIN } from "./format.js";
import { settings } from "./settings.js";

const FOOT_M = 0.3048;
const KNOT = 1852 / 3600; // metres per second
const MILE_M = 1852;

/**
 * Units of height: text in the list, symbol beside a value, and conversion from metres above sea level.
 * @type {Record<HeightUnit, [string, string, (metres: number) => number]>}
 */
export const HEIGHTS = {
  m: ["m above sea level", "m", (metres) => metres],
  ft: ["ft above sea level", "ft", (metres) => metres / FOOT_M],
  FL: ["flight level (standard pressure)", "FL", (metres) => metres / FOOT_M / 100],
  "m-agl": ["m above the ground stated below", "m AGL", (metres) => metres - (settings.groundM ?? 0)],
  "ft-agl": ["ft above the ground stated below", "ft AGL", (metres) => (metres - (settings.groundM ?? 0)) / FOOT_M],
};

/**
 * Units of ground speed: text, symbol, and conversion from metres per second.
 * @type {Record<SpeedUnit, [string, string, (value: number) => number]>}
 */
export const SPEEDS = {
  "m/s": ["m/s", "m/s", (value) => value],
  kt: ["knots", "kt", (value) => value / KNOT],
  "km/h": ["km/h", "km/h", (value) => value * 3.6],
};

/**
 * Units of distance: short unit and long unit, with their lengths in metres.
 * @type {Record<DistanceUnit, [string, [string, number], [string, number]]>}
 */
export const DISTANCES = {
  m: ["m and km", ["m", 1], ["km", 1000]],
  nm: ["ft and nautical miles", ["ft", FOOT_M], ["NM", MILE_M]],
};

/** Unit of height. Above ground only if the operator has entered the ground's height; else above sea level. */
export function heightUnit() {
  const { height } = settings.units;
  if (settings.groundM !== null) return height;
  return height === "m-agl" ? "m" : height === "ft-agl" ? "ft" : height;
}

/**
 * Number of a height in metres above sea level, without its unit; "–" if unknown.
 * @param {number | undefined} metres @param {number} [digits]
 */
export function plainHeight(metres, digits = 0) {
  if (!Number.isFinite(metres)) return "–";
  const unit = heightUnit();
  const value = HEIGHTS[unit][2](metres);
  return unit === "FL" ? String(Math.max(0, Math.round(value))).padStart(3, "0") : grouped(value, digits);
}

/** Height with its unit: "124 m", "FL004". @param {number | undefined} metres @param {number} [digits] */
export function height(metres, digits = 0) {
  if (!Number.isFinite(metres)) return "–";
  const unit = heightUnit();
  return unit === "FL" ? `FL${plainHeight(metres)}` : `${plainHeight(metres, digits)}${THIN}${HEIGHTS[unit][1]}`;
}

/** Heading for heights, with their reference. */
export const heightName = () => (heightUnit() === "FL" ? "Flight level (standard pressure)" : heightUnit().endsWith("-agl") ? "Height above ground" : "Height AMSL");

export const heightWords = () => HEIGHTS[heightUnit()][0];

/** Metres above sea level from the operator's input in the current unit; null if it is not a number. @param {string} text */
export function metresOf(text) {
  const value = text.trim() === "" ? NaN : Number(text);
  if (!Number.isFinite(value)) return null;
  const [, , of] = HEIGHTS[heightUnit()];
  return (value - of(0)) / (of(1) - of(0));
}

/** @param {number | undefined} value */
export const plainSpeed = (value) => (Number.isFinite(value) ? grouped(SPEEDS[settings.units.speed][2](value)) : "–");

/** @param {number | undefined} value @param {number} [digits] */
export const speed = (value, digits = 0) =>
  Number.isFinite(value) ? `${grouped(SPEEDS[settings.units.speed][2](value), digits)}${THIN}${settings.units.speed}` : "–";

const LONG = 10; // number of long units from which on they are used

/** @param {number | undefined} metres */
export function distance(metres) {
  if (!Number.isFinite(metres)) return "–";
  const [, [short, shortM], [long, longM]] = DISTANCES[settings.units.distance];
  return metres < LONG * longM && !(long === "NM" && metres >= longM)
    ? `${grouped(metres / shortM)}${THIN}${short}`
    : `${(metres / longM).toFixed(1)}${THIN}${long}`;
}

/** Round number (1, 2 or 5 times a power of ten, in the displayed unit) of at least `least`; in metres. @param {number} least */
export function roundDistance(least) {
  const [, [, shortM], [long, longM]] = DISTANCES[settings.units.distance];
  const unit = least >= (long === "NM" ? longM / 2 : longM) ? longM : shortM;
  const power = 10 ** Math.floor(Math.log10(least / unit));
  const digit = [1, 2, 5].find((digit) => digit * power >= (least / unit) * 0.999) ?? 10;
  return digit * power * unit;
}

/** Unit of a column of distances. */
export const distanceUnit = () => (settings.units.distance === "nm" ? "NM" : "m");
/** A distance in that unit, without the unit. @param {number | undefined} metres */
export const plainDistance = (metres) => {
  if (!Number.isFinite(metres)) return "–";
  return settings.units.distance === "nm" ? (metres / MILE_M).toFixed(2) : grouped(metres);
};

/** Vertical speed, in units that match those of heights. @param {number} value */
export const climb = (value) =>
  heightUnit().startsWith("m") ? `${grouped(value, 1)}${THIN}m/s` : `${grouped((value / FOOT_M) * 60)}${THIN}ft/min`;

const LEVEL = 0.5; // metres per second; less counts as level flight

/** "↑" in a climb, "↓" in a descent, "" in level flight or if unknown. @param {Track} track */
export const climbArrow = ({ properties: { vertical_speed: value = 0 } }) => (value > LEVEL ? "↑" : value < -LEVEL ? "↓" : "");
