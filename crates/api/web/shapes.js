// GeoJSON on the map: coverage and zones of the service, and the user's own overlays, which never leave the page.

import { FONT, writeFree } from "./fixtures.js";
import { palette } from "./palette.js";

/** A name and its place. @typedef {[...Point, string]} Named */

/** A GeoJSON object as paths in metres, made once. Drawing takes one stroke at any zoom. */
export class Shapes {
  /** @param {string} name @param {GeoJson} geojson @param {Frame} frame */
  constructor(name, geojson, frame) {
    this.name = name;
    this.geojson = geojson;
    this.frame = frame;
    this.lines = new Path2D();
    this.surfaces = new Path2D();
    /** @type {Named[]} */
    this.points = [];
    /** @type {Named[]} */
    this.names = []; // of surfaces and lines
    /** @type {[...Box, string][]} */
    this.boxes = []; // of surfaces, in metres, with their names
    /** @type {Point[]} */
    this.places = []; // all places, to fit the view
    this.add(geojson, "");
  }

  /** The same shapes in another frame. @param {Frame} frame */
  in(frame) {
    return new Shapes(this.name, this.geojson, frame);
  }

  /** @param {GeoJson | null | undefined} object @param {string} name */
  add(object, name) {
    switch (object?.type) {
      case "FeatureCollection":
        for (const feature of object.features ?? []) this.add(feature, "");
        break;
      case "Feature": {
        const { name, title, id } = object.properties ?? {};
        this.add(object.geometry, String(name ?? title ?? id ?? object.id ?? ""));
        break;
      }
      case "GeometryCollection":
        for (const geometry of object.geometries ?? []) this.add(geometry, name);
        break;
      case "Point":
        this.addPoint(object.coordinates, name);
        break;
      case "MultiPoint":
        for (const point of object.coordinates) this.addPoint(point, name);
        break;
      case "LineString":
        this.addLine(this.lines, object.coordinates, name);
        break;
      case "MultiLineString":
        object.coordinates.forEach((line, i) => this.addLine(this.lines, line, i ? "" : name));
        break;
      case "Polygon":
        this.addSurface(object.coordinates, name);
        break;
      case "MultiPolygon":
        object.coordinates.forEach((polygon, i) => this.addSurface(polygon, i ? "" : name));
        break;
    }
  }

  /** @param {number[]} place */
  local([lng, lat]) {
    const place = this.frame.toLocal(lat, lng);
    if (!place.every(Number.isFinite)) throw new Error("a coordinate is not a number");
    this.places.push(place);
    return place;
  }

  /** @param {number[]} coordinates @param {string} name */
  addPoint(coordinates, name) {
    this.points.push([...this.local(coordinates), name]);
  }

  /** @param {number[][][]} rings @param {string} name */
  addSurface(rings, name) {
    const before = this.places.length;
    rings.forEach((ring, i) => this.addLine(this.surfaces, ring, i ? "" : name));
    const [x, y] = [0, 1].map((axis) => this.places.slice(before).map((place) => place[axis]));
    if (name && x.length) this.boxes.push([Math.min(...x), Math.max(...y), Math.max(...x), Math.min(...y), name]);
  }

  /** @param {Path2D} path @param {number[][]} coordinates @param {string} name */
  addLine(path, coordinates, name) {
    coordinates.forEach((coordinate, i) => {
      const [x, y] = this.local(coordinate);
      if (i) path.lineTo(x, y);
      else path.moveTo(x, y);
    });
    if (name && coordinates.length) this.names.push([...this.local(northmost(coordinates)), name]);
  }

  /**
   * Names are at the northernmost point or, if `inside`, at the top of the visible part of the surface.
   * @param {Context} context @param {View} view @param {string} colour
   * @param {{ fill?: number, dash?: number[], inside?: boolean }} [look]
   */
  draw(context, view, colour, { fill = 0.08, dash = [], inside = false } = {}) {
    context.save();
    context.translate(view.width / 2, view.height / 2);
    context.scale(view.scale, -view.scale);
    context.translate(-view.x, -view.y);
    context.fillStyle = colour;
    context.globalAlpha = fill;
    if (fill) context.fill(this.surfaces, "evenodd");
    context.globalAlpha = 1;
    context.strokeStyle = colour;
    context.lineWidth = 1.25 / view.scale;
    context.setLineDash(dash.map((length) => length / view.scale));
    context.stroke(this.surfaces);
    context.stroke(this.lines);
    context.restore();

    context.font = FONT;
    context.textBaseline = "bottom";
    context.textAlign = "left";
    for (const [x, y, name] of this.points) {
      const [px, py] = view.toScreen(x, y);
      if (!view.contains(px, py)) continue;
      context.strokeStyle = colour;
      context.lineWidth = 1.5;
      context.strokeRect(px - 3, py - 3, 6, 6);
      if (name) writeFree(context, view, name, px + 6, py - 2, colour);
    }
    context.textAlign = "center";
    for (const [px, py, name] of inside ? this.namesInside(view) : this.namesAbove(view)) writeFree(context, view, name, px, py, colour);
  }

  /** @param {View} view @returns {Named[]} */
  namesAbove(view) {
    return this.names.map(([x, y, name]) => {
      const [px, py] = view.toScreen(x, y);
      return [px, py - 3, name];
    });
  }

  /** @param {View} view @returns {Named[]} */
  namesInside(view) {
    return this.boxes.flatMap(([left, top, right, bottom, name]) => {
      const [[pxLeft, pyTop], [pxRight, pyBottom]] = [view.toScreen(left, top), view.toScreen(right, bottom)];
      const [from, to, edge] = [Math.max(pxLeft, 0), Math.min(pxRight, view.width), Math.max(pyTop, 0)];
      return from < to && edge + BELOW_PX < Math.min(pyBottom, view.height) ? [[(from + to) / 2, edge + BELOW_PX, name]] : [];
    });
  }
}

const BELOW_PX = 40; // distance from the edge, below the names of bearings

/** @param {number[][]} coordinates */
const northmost = (coordinates) => coordinates.reduce((best, at) => (at[1] > best[1] ? at : best));

/** @param {Context} context @param {View} view @param {Shapes} shapes */
export function drawCoverage(context, view, shapes) {
  shapes.draw(context, view, palette.coverage, { fill: 0, dash: [6, 4] });
}

/** Cells of a cluster, each with its owner. @param {Context} context @param {View} view @param {Shapes} shapes */
export function drawCells(context, view, shapes) {
  shapes.draw(context, view, palette.quiet, { fill: 0, dash: [12, 4, 2, 4], inside: true });
}

/** @param {Context} context @param {View} view @param {Shapes} shapes */
export function drawOverlay(context, view, shapes) {
  shapes.draw(context, view, palette.overlay, { fill: 0.06 });
}
