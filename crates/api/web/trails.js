// Trails of the tracks: lines that fade with age.

import { palette } from "./palette.js";
import { settings, SOURCES } from "./settings.js";

const BANDS = 6; // steps of fading: one path per step and source, for any number of tracks
const BREAK_MS = 5000; // a longer silence is a gap in the trail, not a straight line
const STEP_PX = 4;
const THIN_PX = 1; // wider lines are drawn as surfaces, which is several times slower

/** @param {Context} context @param {View} view @param {Track[]} tracks @param {number} now */
export function drawTrails(context, view, tracks, now) {
  context.lineJoin = "bevel";
  const chosen = tracks.find((track) => track.id === settings.selected);
  for (const source of SOURCES) {
    const paths = Array.from({ length: BANDS }, () => new Path2D());
    for (const track of tracks) if (track.source === source && track !== chosen) addTrail(paths, view, track, now);
    stroke(context, paths, palette[source], THIN_PX, 0.65);
  }
  if (chosen) {
    const paths = Array.from({ length: BANDS }, () => new Path2D());
    addTrail(paths, view, chosen, now);
    stroke(context, paths, palette[chosen.source], 2.5, 0.9);
  }
  context.globalAlpha = 1;
}

/** @param {Context} context @param {Path2D[]} paths @param {string} colour @param {number} width @param {number} strongest */
function stroke(context, paths, colour, width, strongest) {
  context.strokeStyle = colour;
  context.lineWidth = width;
  paths.forEach((path, band) => {
    context.globalAlpha = strongest * (1 - band / BANDS);
    context.stroke(path);
  });
}

/**
 * From the track backwards, one line through each band. Points at the same pixel are skipped.
 * @param {Path2D[]} paths @param {View} view @param {Track} track @param {number} now
 */
function addTrail(paths, view, track, now) {
  const { trail } = track;
  const longest = settings.trailS * 1000;
  let [px, py] = view.toScreen(track.x, track.y);
  let before = track.time;
  let penIn = -1; // band whose path ends at (px, py)
  for (let i = trail.length - 1; i >= 0; i--) {
    const at = trail.at(i);
    const time = trail.values[at];
    const age = now - time;
    if (age > longest) break;
    const [x, y] = view.toScreen(trail.values[at + 1], trail.values[at + 2]);
    if (i > 0 && Math.abs(x - px) + Math.abs(y - py) < STEP_PX && before - time <= BREAK_MS) continue;
    const band = Math.max(0, Math.min(BANDS - 1, Math.floor((age / longest) * BANDS)));
    if (before - time > BREAK_MS || !(view.contains(px, py, 20) || view.contains(x, y, 20))) {
      penIn = -1;
    } else {
      if (penIn !== band) paths[band].moveTo(px, py);
      paths[band].lineTo(x, y);
      view.space.trace(x, y);
      penIn = band;
    }
    [px, py, before] = [x, y, time];
  }
}
