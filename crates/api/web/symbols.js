// Tracks on the map: shape by source or aeroplane, colour by source or height, and predicted movement.

import { precedence } from "./attention.js";
import { colourOf } from "./heights.js";
import { palette } from "./palette.js";
import { settings, SOURCES } from "./settings.js";
import { Sprites } from "./sprites.js";

const AHEAD_S = 10;
const QUIET_MS = 2000; // a track without news for this time is drawn faint
const LEAST_PX = 6; // minimum size of an ellipse or circle that the symbol does not hide

/** @type {Record<Source, (path: CanvasPath, x: number, y: number, r: number) => void>} */
const SHAPES = {
  fused: (path, x, y, r) => {
    path.moveTo(x + r, y);
    path.arc(x, y, r, 0, 2 * Math.PI);
  },
  radar: (path, x, y, r) => {
    path.moveTo(x, y - r * 1.25);
    path.lineTo(x + r * 1.15, y + r * 0.85);
    path.lineTo(x - r * 1.15, y + r * 0.85);
    path.closePath();
  },
  transponder: (path, x, y, r) => {
    path.moveTo(x, y - r * 1.3);
    path.lineTo(x + r * 1.3, y);
    path.lineTo(x, y + r * 1.3);
    path.lineTo(x - r * 1.3, y);
    path.closePath();
  },
  camera: (path, x, y, r) => path.rect(x - r, y - r, 2 * r, 2 * r),
};

/** Symbol of crewed aircraft, whatever the sensor: nose, wings and tail, the nose to the north. */
const AEROPLANE = [[0, -2], [0.3, -0.7], [1.9, 0.3], [1.9, 0.75], [0.3, 0.35], [0.2, 1.2], [0.75, 1.7], [0.75, 2], [0, 1.75]];

/** @param {CanvasPath} path @param {number} r */
function aeroplane(path, r) {
  const outline = [...AEROPLANE, ...AEROPLANE.toReversed().map(([x, y]) => [-x, y])];
  outline.forEach(([x, y], i) => (i ? path.lineTo(x * r, y * r) : path.moveTo(x * r, y * r)));
  path.closePath();
}

const TURN = 10; // degrees between two images of an aeroplane

/** Heading of the nearest aeroplane image, in degrees. @param {Track} track */
const headingOf = (track) => (track.isCrewed && Number.isFinite(track.course) ? Math.round(track.course / TURN) * TURN : 0);

/**
 * Places of the tracks, [track, px, py, rank], for labels and clicks; the most important last, so on top.
 * @param {View} view @param {Track[]} tracks @param {Map<string, Severity>} alerted
 */
export function place(view, tracks, alerted) {
  /** @type {Placed[]} */
  const placed = [];
  for (const track of tracks) {
    const [px, py] = view.toScreen(track.x, track.y);
    if (view.contains(px, py, 30)) placed.push([track, px, py, rankOf(track, alerted)]);
  }
  return placed.sort((one, other) => other[3] - one[3]);
}

/**
 * Lower is more important: selected track, alerts, then as in the table.
 * @param {Track} track @param {Map<string, Severity>} alerted
 */
const rankOf = (track, alerted) => (track.id === settings.selected ? -2 : alerted.has(track.id) ? -1 : precedence(track));

const sprites = new Sprites();

/** After a change of colours or screen all symbols are drawn again. */
export const forgetSymbols = () => sprites.clear();

/** Unidentified tracks are larger. @param {Track} track @param {View} view */
const radiusOf = (track, view) => (view.scale > 0.02 ? 4.2 : 3.3) * (track.isUnknown ? 1.3 : 1);

/**
 * @param {Context} context @param {View} view @param {Placed[]} placed @param {number} now
 * @param {Map<string, Severity>} alerted
 */
export function drawSymbols(context, view, placed, now, alerted) {
  for (const [track, px, py] of placed) {
    const radius = radiusOf(track, view);
    const colour = colourOf(track);
    context.globalAlpha = now - track.time > QUIET_MS ? 0.45 : 1;
    const kind = track.isCrewed ? "crewed" : track.isVehicle ? "vehicle" : "";
    const look = [track.source, kind, headingOf(track), colour, radius, track.isDoubtful, track.isExtrapolated].join(" ");
    sprites.put(context, look, radius * (track.isCrewed ? 2.3 : 1.5) + 3, px, py, (sprite) => symbol(sprite, track, radius, colour));
    context.globalAlpha = 1;
    const severity = alerted.get(track.id);
    if (severity) ring(context, px, py, 10, palette[severity] ?? palette.warning, 2);
    if (settings.watched.has(track.watchId)) ring(context, px, py, 8, palette.selected, 1);
    if (track.id === settings.selected) bracket(context, px, py, 13);
  }
}

/**
 * Symbol about the origin: filled; hollow if it is unlikely to be a drone; dashed if extrapolated.
 * @param {Context} context @param {Track} track @param {number} radius @param {string} colour
 */
function symbol(context, track, radius, colour) {
  const isHollow = track.isDoubtful || track.isExtrapolated;
  context.beginPath();
  if (track.isCrewed) {
    context.rotate((headingOf(track) * Math.PI) / 180);
    aeroplane(context, radius);
  } else if (track.isVehicle) context.rect(-radius, -radius, 2 * radius, 2 * radius);
  else SHAPES[track.source]?.(context, 0, 0, radius);
  context.lineWidth = isHollow ? 1.5 : 2.5;
  context.strokeStyle = isHollow ? colour : palette.halo;
  context.fillStyle = isHollow ? palette.halo : colour;
  if (!isHollow) context.stroke();
  context.fill();
  if (track.isExtrapolated) context.setLineDash([2, 2]);
  if (isHollow) context.stroke();
}

/**
 * Uncertainty of positions (95 %). Predicted tracks have ellipses. Otherwise the selected track has a circle, and on demand all
 * tracks. Left out if the symbol covers it.
 * @param {Context} context @param {View} view @param {Placed[]} placed
 */
export function drawUncertainty(context, view, placed) {
  context.save();
  context.lineWidth = 1;
  for (const [track, px, py] of placed) {
    const isSelected = track.id === settings.selected;
    const { accuracy_ellipse: ellipse, accuracy_h_m = NaN } = track.properties;
    if (!ellipse && !isSelected && !settings.layers.ellipses) continue;
    const [major, minor] = ellipse ? [ellipse.major_m * view.scale, ellipse.minor_m * view.scale] : [accuracy_h_m * view.scale, accuracy_h_m * view.scale];
    if (!(major > LEAST_PX)) continue;
    context.strokeStyle = isSelected ? palette.selected : palette[track.source];
    context.setLineDash(ellipse ? [] : [2, 3]);
    context.beginPath();
    context.ellipse(px, py, major, minor, (((ellipse?.azimuth_deg ?? 90) - 90) * Math.PI) / 180, 0, 2 * Math.PI);
    context.stroke();
    if (!isSelected) continue;
    context.globalAlpha = 0.08;
    context.fillStyle = palette.selected;
    context.fill();
    context.globalAlpha = 1;
  }
  context.restore();
}

/**
 * Predicted straight movement, dashed to distinguish it from a trail.
 * @param {Context} context @param {View} view @param {Placed[]} placed
 */
export function drawVectors(context, view, placed) {
  context.save();
  context.setLineDash([5, 3]);
  context.lineWidth = 1;
  for (const source of SOURCES) {
    context.strokeStyle = palette[source];
    context.beginPath();
    for (const [track, px, py] of placed) {
      if (track.source !== source || !Number.isFinite(track.course)) continue;
      const angle = (track.course * Math.PI) / 180;
      const length = track.speed * AHEAD_S * view.scale;
      if (length < 7) continue;
      context.moveTo(px, py);
      context.lineTo(px + length * Math.sin(angle), py - length * Math.cos(angle));
    }
    context.stroke();
  }
  context.restore();
}

/**
 * @param {Context} context @param {number} px @param {number} py @param {number} radius @param {string} colour
 * @param {number} width
 */
function ring(context, px, py, radius, colour, width) {
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.beginPath();
  context.arc(px, py, radius, 0, 2 * Math.PI);
  context.stroke();
}

/**
 * Four corners about the selected track, which hide nothing and differ from all symbols.
 * @param {Context} context @param {number} px @param {number} py @param {number} r
 */
function bracket(context, px, py, r) {
  context.strokeStyle = palette.selected;
  context.lineWidth = 2;
  context.beginPath();
  for (const [sx, sy] of [[1, 1], [1, -1], [-1, 1], [-1, -1]]) {
    context.moveTo(px + sx * r, py + sy * (r - 6));
    context.lineTo(px + sx * r, py + sy * r);
    context.lineTo(px + sx * (r - 6), py + sy * r);
  }
  context.stroke();
}
