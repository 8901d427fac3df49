// The tracks on the map: trails that fade, a shape and a colour by source, where each will be, and labels.

import { TRAIL_S } from "./api.js";
import * as format from "./format.js";
import { FONT, write } from "./furniture.js";
import { palette } from "./palette.js";
import { settings, SOURCES } from "./settings.js";

const BANDS = 6; // steps of fading: one path each and source, however many tracks
const BREAK_MS = 5000; // a longer silence is a gap in the trail, not a straight line
const STEP_PX = 3;
const AHEAD_S = 10;
const QUIET_MS = 2000; // without news this long, a track is drawn faint
const LINE_PX = 13;
const CELL_PX = 64;

export function drawTrails(context, view, tracks, now) {
  context.lineJoin = "bevel";
  const chosen = tracks.find((track) => track.id === settings.selected);
  for (const source of SOURCES) {
    const paths = Array.from({ length: BANDS }, () => new Path2D());
    for (const track of tracks) if (track.source === source) addTrail(paths, view, track, now);
    context.strokeStyle = palette[source];
    context.lineWidth = 1.25;
    strokeBands(context, paths, 0.6);
  }
  if (chosen) {
    const paths = Array.from({ length: BANDS }, () => new Path2D());
    addTrail(paths, view, chosen, now);
    context.strokeStyle = palette[chosen.source];
    context.lineWidth = 2.5;
    strokeBands(context, paths, 0.9);
  }
  context.globalAlpha = 1;
}

function strokeBands(context, paths, strongest) {
  paths.forEach((path, band) => {
    context.globalAlpha = strongest * (1 - band / BANDS);
    context.stroke(path);
  });
}

/** From the track backwards, one line through each band; points that fall on the same place are passed over. */
function addTrail(paths, view, track, now) {
  const { trail } = track;
  let [px, py] = view.toScreen(track.x, track.y);
  let before = track.time;
  let penIn = -1; // the band whose path ends at (px, py)
  for (let i = trail.length - 1; i >= 0; i--) {
    const at = trail.at(i);
    const time = trail.values[at];
    const age = now - time;
    if (age > TRAIL_S * 1000) break;
    const [x, y] = view.toScreen(trail.values[at + 1], trail.values[at + 2]);
    if (i > 0 && Math.abs(x - px) + Math.abs(y - py) < STEP_PX && before - time <= BREAK_MS) continue;
    const band = Math.max(0, Math.min(BANDS - 1, Math.floor((age / TRAIL_S / 1000) * BANDS)));
    if (before - time > BREAK_MS || !(view.contains(px, py, 20) || view.contains(x, y, 20))) {
      penIn = -1;
    } else {
      if (penIn !== band) paths[band].moveTo(px, py);
      paths[band].lineTo(x, y);
      penIn = band;
    }
    [px, py, before] = [x, y, time];
  }
}

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
};

/** Where each track is drawn, [track, px, py], for the labels and the clicks; the selected one last, so on top. */
export function place(view, tracks) {
  const placed = [];
  for (const track of tracks) {
    const [px, py] = view.toScreen(track.x, track.y);
    if (view.contains(px, py, 30)) placed.push([track, px, py]);
  }
  return placed.sort(([a], [b]) => (a.id === settings.selected) - (b.id === settings.selected));
}

export function drawSymbols(context, view, placed, now, alerted) {
  const radius = view.scale > 0.02 ? 4.5 : 3.5;
  for (const [track, px, py] of placed) {
    context.globalAlpha = now - track.time > QUIET_MS ? 0.45 : 1;
    const colour = palette[track.source];
    const isHollow = track.isDoubtful || track.isExtrapolated;
    const path = new Path2D();
    SHAPES[track.source]?.(path, px, py, radius);
    context.lineWidth = isHollow ? 1.5 : 2.5;
    context.strokeStyle = isHollow ? colour : palette.halo;
    context.fillStyle = isHollow ? palette.halo : colour;
    if (!isHollow) context.stroke(path);
    context.fill(path);
    context.setLineDash(track.isExtrapolated ? [2, 2] : []);
    if (isHollow) context.stroke(path);
    context.setLineDash([]);
    context.globalAlpha = 1;
    const severity = alerted.get(track.id);
    if (severity) ring(context, px, py, 10, palette[severity] ?? palette.warning, 2);
    if (track.id === settings.selected) bracket(context, px, py, 13);
  }
}

/** Within its ellipse each predicted track is, 95 times of 100; left out where the symbol covers it. */
export function drawEllipses(context, view, placed) {
  context.save();
  context.lineWidth = 1;
  for (const [track, px, py] of placed) {
    const { major_m, minor_m, azimuth_deg } = track.properties.accuracy_ellipse ?? {};
    const [major, minor] = [major_m * view.scale, minor_m * view.scale];
    if (!(major > 6)) continue;
    context.strokeStyle = track.id === settings.selected ? palette.selected : palette[track.source];
    context.beginPath();
    context.ellipse(px, py, major, minor, ((azimuth_deg - 90) * Math.PI) / 180, 0, 2 * Math.PI);
    context.stroke();
  }
  context.restore();
}

/** Within this circle the selected track is, 95 times of 100; left out where the symbol covers it, and where it has an ellipse. */
export function drawAccuracy(context, view, track) {
  if (track.properties.accuracy_ellipse) return;
  const radius = track.properties.accuracy_h_m * view.scale;
  if (!(radius > 6)) return;
  const [px, py] = view.toScreen(track.x, track.y);
  context.save();
  context.setLineDash([2, 3]);
  ring(context, px, py, radius, palette.selected, 1.5);
  context.globalAlpha = 0.08;
  context.fillStyle = palette.selected;
  context.fill();
  context.restore();
}

/** Where each will be, should it go on straight: dashed, not to be taken for a trail. */
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

function ring(context, px, py, radius, colour, width) {
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.beginPath();
  context.arc(px, py, radius, 0, 2 * Math.PI);
  context.stroke();
}

/** Four corners about the selected track: it hides nothing and is no shape of a source. */
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

export function labelLines(track) {
  const { alt_msl } = track.properties;
  const name = (settings.labelBy === "serial" && track.serial) || track.name;
  const second = [];
  if (Number.isFinite(alt_msl)) second.push(format.metres(alt_msl));
  if (Number.isFinite(track.speed)) second.push(`${track.derived ? "≈" : ""}${format.speed(track.speed)}`);
  return second.length ? [name, second.join(" ")] : [name];
}

const RANK = { fused: 0, transponder: 1, radar: 2 };

/** Labels beside their symbols, where nothing else is; in a crowd the name alone, or nothing where even that has no room. */
export function drawLabels(context, view, placed, alerted) {
  context.font = FONT;
  context.textAlign = "left";
  context.textBaseline = "middle";
  const taken = new Boxes();
  for (const [, px, py] of placed) taken.add([px - 5, py - 5, px + 5, py + 5]);
  const rank = (track) =>
    track.id === settings.selected ? -2 : alerted.has(track.id) ? -1 : RANK[track.source] + (track.isDoubtful ? 1 : 0);
  const character = context.measureText("0").width;
  for (const [track, px, py] of [...placed].sort(([a], [b]) => rank(a) - rank(b))) {
    const all = labelLines(track);
    // Where it was is tried first: a label that jumps cannot be read.
    for (let attempt = 0; attempt < 8; attempt++) {
      const lines = attempt < 4 ? all : all.slice(0, 1);
      const width = Math.max(...lines.map((line) => line.length)) * character;
      const height = lines.length * LINE_PX;
      const side = (track.place + attempt) % 4;
      const beside = track.id === settings.selected ? 17 : 9; // clear of the bracket
      const left = side % 2 === 0 ? px + beside : px - beside - width;
      const top = side < 2 ? py - height - 1 : py + 1;
      const box = [left - 2, top, left + width + 2, top + height];
      if (taken.hits(box) || !view.isFree(box)) continue;
      taken.add(box);
      track.place = side;
      const colour = track.id === settings.selected ? palette.selected : palette.ink;
      lines.forEach((line, i) => write(context, line, left, top + LINE_PX * (i + 0.5), i ? palette.quiet : colour));
      break;
    }
  }
}

/** Rectangles [left, top, right, bottom] in cells, so that 500 labels need not be compared with each other. */
class Boxes {
  cells = new Map();

  *around([left, top, right, bottom]) {
    for (let x = Math.floor(left / CELL_PX); x <= Math.floor(right / CELL_PX); x++) {
      for (let y = Math.floor(top / CELL_PX); y <= Math.floor(bottom / CELL_PX); y++) yield x * 4096 + y;
    }
  }

  add(box) {
    for (const cell of this.around(box)) {
      if (!this.cells.has(cell)) this.cells.set(cell, []);
      this.cells.get(cell).push(box);
    }
  }

  hits([left, top, right, bottom]) {
    for (const cell of this.around([left, top, right, bottom])) {
      for (const other of this.cells.get(cell) ?? []) {
        if (left < other[2] && other[0] < right && top < other[3] && other[1] < bottom) return true;
      }
    }
    return false;
  }
}
