// The canvas: order of drawing, at most once per screen frame, and the effect of clicks.

import { chosenOf, drawCrowds } from "./crowds.js";
import { contextOf } from "./dom.js";
import { drawRadars, drawRings, drawScale, scaleBox } from "./fixtures.js";
import { drawLabels } from "./labels.js";
import { palette } from "./palette.js";
import { Covers, FreeSpace } from "./freespace.js";
import { change, settings } from "./settings.js";
import { drawCells, drawCoverage, drawOverlay } from "./shapes.js";
import { drawSymbols, drawUncertainty, drawVectors, forgetSymbols, place } from "./symbols.js";
import { drawTrails } from "./trails.js";
import { drawTrust } from "./trust.js";
import { steer, View } from "./view.js";

const REACH_PX = 16; // maximum distance of a click from a symbol
const PAN_PX = 80;

/** @type {(thing: { x: number, y: number }) => Point} */
const placeOf = ({ x, y }) => [x, y];

export class Map2d {
  view = new View();
  /** @type {Picture | null} */
  picture = null; // until there is an origin
  /** @type {Radar[]} */
  radars = [];
  /** @type {Shapes | null} */
  coverage = null;
  /** @type {Shapes | null} */
  cells = null;
  /** @type {Zones | null} */
  areas = null;
  /** @type {Shapes[]} */
  overlays = [];
  /** @type {Tiles<VectorTiles> | null} */
  base = null;
  /** @type {Tiles<PictureTiles> | null} */
  tiles = null;
  /** @type {Raw | null} */
  raw = null;
  /** @type {Conflicts | null} */
  conflicts = null; // predicted conflicts
  /** @type {Tool | null} */
  tool = null;
  /** @type {Map<string, Severity>} */
  alerted = new Map(); // severity by track id
  /** @type {Placed[]} */
  placed = [];
  waiting = false;
  framed = false; // whether the view was set by the hash, the user or the first picture

  /** @type {Steering["hovered"]} */
  hovered = () => {}; // called with the pointer's position, or without arguments when it has left the canvas

  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    this.context = contextOf(canvas, { alpha: false });
    this.covers = new Covers(canvas, () => this.invalidate());
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.resize();
    steer(canvas, this.view, {
      moved: (isPan) => this.moved(isPan),
      clicked: (px, py) => this.click(px, py),
      hovered: (px, py) => this.hovered(px, py),
    });
  }

  /** Changes the origin; everything keeps its position on the ground. @param {Frame} frame */
  reframe(frame) {
    if (!this.picture) return;
    const before = this.picture.frame;
    /** @param {number} x @param {number} y */
    const moved = (x, y) => frame.toLocal(...before.toGeodetic(x, y));
    this.picture.reframe(frame);
    [this.view.x, this.view.y] = moved(this.view.x, this.view.y);
    [this.coverage, this.cells] = [this.coverage?.in(frame) ?? null, this.cells?.in(frame) ?? null];
    this.areas = this.areas?.in(frame) ?? null;
    this.overlays = this.overlays.map((overlay) => overlay.in(frame));
    for (const tiles of [this.base, this.tiles]) if (tiles) tiles.frame = frame;
    this.raw?.move(moved);
    this.invalidate();
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas;
    const ratio = window.devicePixelRatio || 1;
    Object.assign(this.view, { width: Math.max(1, clientWidth), height: Math.max(1, clientHeight) });
    this.canvas.width = Math.round(this.view.width * ratio);
    this.canvas.height = Math.round(this.view.height * ratio);
    this.context.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.repaint();
  }

  /** Redraws everything after a change of colours or screen. */
  repaint() {
    this.forgetColours();
    this.invalidate();
  }

  /** Redraws everything without waiting for a frame. */
  repaintNow() {
    this.forgetColours();
    this.draw();
  }

  forgetColours() {
    forgetSymbols();
    this.base?.source.repaint();
  }

  invalidate() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.draw();
    });
  }

  draw() {
    const { context, view } = this;
    context.fillStyle = palette.map;
    context.fillRect(0, 0, view.width, view.height);
    if (!this.picture) return;
    view.space = new FreeSpace(view.width, view.height, [...this.covers.find(), scaleBox(view)]);
    const { layers } = settings;
    const selected = this.picture.tracks.get(settings.selected ?? "");
    if (settings.follow && selected) [view.x, view.y] = [selected.x, selected.y];
    const tracks = this.picture.visible();
    const { time } = this.picture;

    // From the ground up.
    if (layers.base && this.base) this.base.draw(context, view);
    if (layers.tiles && this.tiles) this.tiles.draw(context, view);
    if (layers.coverage && this.coverage) drawCoverage(context, view, this.coverage);
    if (layers.cells && this.cells) drawCells(context, view, this.cells);
    if (layers.areas && this.areas) this.areas.draw(context, view);
    for (const overlay of this.overlays) drawOverlay(context, view, overlay);
    if (layers.rings && this.picture.frame.isRadar) drawRings(context, view);
    if (layers.base && this.base) this.base.drawNames(context, view);
    if (layers.trails) drawTrails(context, view, tracks, time);
    drawRadars(context, view, this.radars);
    if (layers.raw) this.raw?.draw(context, view, time);
    this.placed = place(view, tracks, this.alerted);
    drawUncertainty(context, view, this.placed);
    if (layers.vectors) drawVectors(context, view, this.placed);
    drawTrust(context, view, this.placed);
    this.conflicts?.draw(context, view, this.placed, this.picture.frame);
    drawCrowds(context, view, this.placed);
    if (layers.labels) drawLabels(context, view, this.placed);
    drawSymbols(context, view, this.placed, time, this.alerted);
    this.tool?.draw(context, view);
    drawScale(context, view);
  }

  /** Called after the user moved the view. A pan ends following. @param {boolean} isPan */
  moved(isPan) {
    this.framed = true;
    change({
      centre: this.picture?.frame.toGeodetic(this.view.x, this.view.y) ?? settings.centre,
      scale: this.view.scale,
      ...(isPan && settings.follow ? { follow: false } : {}),
    });
    this.invalidate();
  }

  /** @param {number} dx @param {number} dy */
  pan(dx, dy) {
    this.view.pan(dx * PAN_PX, dy * PAN_PX);
    this.moved(true);
  }

  /** @param {number} factor */
  zoom(factor) {
    this.view.zoomAt(this.view.width / 2, this.view.height / 2, factor);
    this.moved(false);
  }

  /** Selects the first of these tracks, and shows them all in the middle. @param {string[]} ids */
  go(ids) {
    const tracks = ids.map((id) => this.picture?.tracks.get(id)).filter((track) => track !== undefined);
    if (!tracks.length) return;
    const places = tracks.map(placeOf);
    const { scale } = this.view;
    this.view.fit(places);
    this.view.setScale(Math.min(scale, this.view.scale)); // zooms out if they do not fit, and never in
    this.moved(true);
    change({ selected: tracks[0].id });
  }

  /** Fits all tracks selected by the filter; without tracks, the coverage of the sensors. */
  fit() {
    const places = (this.picture?.visible() ?? []).map(placeOf);
    if (!places.length) places.push(...(this.coverage?.places ?? []));
    this.view.fit([...places, ...this.radars.map(placeOf)]);
    this.moved(true);
  }

  /** Sets the view of the settings, or that of the first picture. */
  frameOnce() {
    if (this.framed || !this.picture) return;
    if (settings.centre && settings.scale) {
      [this.view.x, this.view.y] = this.picture.frame.toLocal(...settings.centre);
      this.view.setScale(settings.scale);
      this.framed = true;
    } else if (this.picture.tracks.size) {
      const { follow } = settings;
      this.view.fitMost(this.picture.visible().map(placeOf));
      this.moved(true);
      change({ follow });
    } else {
      this.view.fit(this.coverage?.places ?? []);
    }
    this.invalidate();
  }

  /** @param {number} px @param {number} py */
  click(px, py) {
    const best = chosenOf(this.placed, px, py, REACH_PX, settings.selected);
    if (!this.tool) return change({ selected: best?.id ?? null });
    this.tool.add(...this.view.toLocal(px, py), best);
    this.invalidate();
  }
}
