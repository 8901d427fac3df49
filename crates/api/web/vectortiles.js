// The site's own base map: vector tiles of its PMTiles file, each drawn once into an image in the page's colours.

import { getOctets } from "./api.js";
import { contextOf } from "./dom.js";
import { decode } from "./mvt.js";
import { palette } from "./palette.js";

const TILE_PX = 512;
const [KEPT_TILES, KEPT_PICTURES] = [200, 100]; // an image takes 1 MB
const AGAIN_MS = 3000;
const AT_ONCE = 4; // further tiles are requested when one has arrived, if they are still visible

/** @typedef {"green" | "wood" | "farm" | "built" | "water" | "building" | "road" | "border"} MapColour */
/**
 * A surface has a fill, a line has a stroke and its width in pixels. Without `has`, a style is that of all features.
 * @typedef {(feature: DecodedFeature) => boolean} Selection
 * @typedef {{ fill: MapColour, stroke?: undefined, width?: undefined, has?: Selection }} SurfaceStyle
 * @typedef {{ fill?: undefined, stroke: MapColour, width: number, has?: Selection }} LineStyle
 * @typedef {SurfaceStyle | LineStyle} Style
 */

/** @param {DecodedFeature} feature */
const classOf = ({ attributes }) => String(attributes.class ?? attributes.kind);
/** @param {string[]} classes @returns {Selection} */
const among = (classes) => (feature) => classes.includes(classOf(feature));
/** @param {string[]} classes @returns {Selection} */
const outside = (classes) => (feature) => !classes.includes(classOf(feature));

const LAND = ["landcover", "landuse", "natural", "park"];
const FARM = ["farmland", "farm", "orchard", "vineyard"];
const WOOD = ["wood", "forest"];
const BUILT = ["residential", "commercial", "industrial", "retail", "railway", "suburb", "quarter", "neighbourhood", "urban_area"];
const MAJOR = ["motorway", "trunk", "primary", "secondary", "highway", "major_road"];

/**
 * Styles of layers, from the ground up, by the names of OpenMapTiles and Protomaps. Other layers are left out.
 * @type {[string[], DecodedFeature["kind"], Style][]}
 */
const STYLES = [
  [LAND, "polygon", { fill: "built", has: among(BUILT) }],
  [LAND, "polygon", { fill: "farm", has: among(FARM) }],
  [LAND, "polygon", { fill: "green", has: outside([...BUILT, ...FARM, ...WOOD]) }],
  [LAND, "polygon", { fill: "wood", has: among(WOOD) }],
  [["water", "ocean"], "polygon", { fill: "water" }],
  [["waterway", "water", "physical_line"], "line", { stroke: "water", width: 1.5 }],
  [["aeroway"], "polygon", { fill: "road" }],
  [["building", "buildings"], "polygon", { fill: "building" }],
  [["transportation", "roads"], "line", { stroke: "road", width: 1, has: outside(MAJOR) }],
  [["transportation", "roads"], "line", { stroke: "road", width: 2.5, has: among(MAJOR) }],
  [["aeroway"], "line", { stroke: "road", width: 3 }],
  [["boundary", "boundaries"], "line", { stroke: "border", width: 1 }],
];
const PLACES = ["place", "places"];
const WANTED = new Set([...STYLES.flatMap(([names]) => names), ...PLACES]);

/** @param {MapColour} name */
const colour = (name) => palette[`map-${name}`];

/** A name, its rank, and its place in a tile: x and y from 0 to 1. @typedef {[string, number, number, number]} PlaceName */

export class VectorTiles {
  /** @type {Map<string, { layers: DecodedLayer[], names: PlaceName[] } | null>} */
  tiles = new Map(); // by "z/x/y" in the file; null while requested
  /** @type {Map<string, HTMLCanvasElement>} */
  pictures = new Map(); // canvases by "z/x/y" on the screen
  alpha = () => 1; // opaque, because the colours are the page's own
  asking = 0;

  /**
   * `came` receives whether tiles arrive, and the reason if not.
   * @param {{ min_zoom: number, max_zoom: number }} map @param {TilesCame} came
   */
  constructor({ min_zoom, max_zoom }, came) {
    this.smallest = min_zoom;
    this.deepest = max_zoom;
    this.came = came;
  }

  get tilePx() {
    return TILE_PX;
  }

  /** Draws all tiles again in other colours. */
  repaint() {
    this.pictures.clear();
  }

  /**
   * A canvas; null until it can be drawn. Beyond the zoom of the file, a part of its deepest tile is enlarged.
   * @param {number} zoom @param {number} x @param {number} y
   */
  picture(zoom, x, y) {
    if (zoom < this.smallest) return null;
    const key = `${zoom}/${x}/${y}`;
    const known = this.pictures.get(key);
    if (known) return known;
    const above = Math.max(0, zoom - this.deepest);
    const tile = this.tile(zoom - above, x >> above, y >> above);
    if (!tile) return null;
    const drawn = draw(tile.layers, 2 ** above, x - ((x >> above) << above), y - ((y >> above) << above));
    keep(this.pictures, key, drawn, KEPT_PICTURES);
    return drawn;
  }

  /**
   * Names of the tile under a place: [name, rank, x, y] with x and y from 0 to 1 within the tile.
   * @param {number} zoom @param {number} x @param {number} y
   */
  names(zoom, x, y) {
    return zoom < this.smallest || zoom > this.deepest ? [] : (this.tile(zoom, x, y)?.names ?? []);
  }

  /** @param {number} zoom @param {number} x @param {number} y */
  tile(zoom, x, y) {
    const key = `${zoom}/${x}/${y}`;
    const tile = this.tiles.get(key);
    if (tile === undefined && this.asking < AT_ONCE) this.ask(key, zoom, x, y);
    return tile ?? null;
  }

  /** @param {string} key @param {number} z @param {number} x @param {number} y */
  async ask(key, z, x, y) {
    keep(this.tiles, key, null, KEPT_TILES);
    this.asking += 1;
    try {
      const octets = await getOctets(`basemap?z=${z}&x=${x}&y=${y}`);
      const layers = decode(octets, (name) => WANTED.has(name));
      this.tiles.set(key, { layers, names: namesOf(layers) });
      this.asking -= 1;
      this.came(true);
    } catch (error) {
      this.asking -= 1;
      this.came(false, error.message);
      setTimeout(() => this.tiles.delete(key), AGAIN_MS); // then it may be requested again
    }
  }
}

/** @param {DecodedLayer[]} layers */
function namesOf(layers) {
  return layers.filter(({ name }) => PLACES.includes(name)).flatMap(({ extent, features }) =>
    features
      .filter(({ kind, parts, attributes }) => kind === "point" && parts.length && attributes.name)
      .map(({ parts: [[px, py]], attributes: { name, rank, population_rank } }) => (
        /** @type {PlaceName} */ ([String(name), Number(rank ?? -Number(population_rank ?? 0)), px / extent, py / extent])
      )),
  );
}

/** @template T @param {Map<string, T>} known @param {string} key @param {T} value @param {number} most */
function keep(known, key, value, most) {
  known.set(key, value);
  if (known.size > most) known.delete(known.keys().next().value ?? "");
}

/**
 * Draws the part (across, down) of a tile that is `times` as large as an image.
 * @param {DecodedLayer[]} layers @param {number} times @param {number} across @param {number} down
 */
function draw(layers, times, across, down) {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = TILE_PX;
  const context = contextOf(canvas);
  context.translate(-across * TILE_PX, -down * TILE_PX);
  for (const [names, kind, style] of STYLES) {
    for (const { name, extent, features } of layers) {
      if (!names.includes(name)) continue;
      const scale = (TILE_PX * times) / extent;
      const path = new Path2D();
      for (const feature of features) {
        if (feature.kind === kind && (style.has?.(feature) ?? true)) trace(path, feature.parts, scale);
      }
      paint(context, path, style, times);
    }
  }
  return canvas;
}

/** @param {Path2D} path @param {number[][]} parts @param {number} scale */
function trace(path, parts, scale) {
  for (const part of parts) {
    for (let i = 0; i < part.length; i += 2) {
      if (i) path.lineTo(part[i] * scale, part[i + 1] * scale);
      else path.moveTo(part[0] * scale, part[1] * scale);
    }
  }
}

/** @param {Context} context @param {Path2D} path @param {Style} style @param {number} times */
function paint(context, path, { fill, stroke, width }, times) {
  if (fill) {
    context.fillStyle = colour(fill);
    context.fill(path, "evenodd");
  } else {
    context.strokeStyle = colour(stroke);
    context.lineWidth = width * Math.min(2, times);
    context.stroke(path);
  }
}
