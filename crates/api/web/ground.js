// Background of the picture: origin of its frame, radars, coverage, areas and tiles. The origin is the first radar. While no
// radar is known it is the first track, so that tracks need not wait for the sensors.

import { list } from "./api.js";
import { Frame } from "./geo.js";
import { Picture } from "./picture.js";
import { Shapes } from "./shapes.js";
import { PictureTiles } from "./picturetiles.js";
import { Tiles } from "./tiles.js";
import { VectorTiles } from "./vectortiles.js";
import { Zones } from "./zones.js";

export class Ground {
  /** @type {{ id: string, lat: number, lng: number }[]} */
  radars = [];
  /** @type {Map<"coverage" | "cells", GeoJson>} */
  shapes = new Map(); // by layer
  /** @type {AreasAnswer | null} */
  areas = null;
  /** @type {VectorTiles | null} */
  base = null;
  /** @type {PictureTiles | null} */
  tiles = null;

  /**
   * `began` receives the picture as soon as there is one; `tileCame` receives a layer, and whether its latest tiles arrive or the
   * reason why not.
   * @param {Map2d} map @param {(picture: Picture) => void} began
   * @param {(layer: TileLayer, ...came: Parameters<TilesCame>) => void} tileCame
   */
  constructor(map, began, tileCame) {
    this.map = map;
    this.began = began;
    this.tileCame = tileCame;
  }

  /** Takes the answer of /sensors. @param {SensorsAnswer} collection */
  takeSensors(collection) {
    this.radars = list(collection, "features")
      .filter(({ geometry, properties }) => properties.kind === "radar" && geometry?.type === "Point")
      .map(({ geometry: { coordinates: [lng, lat] }, properties: { id } }) => ({ id, lat, lng }));
    if (this.radars.length) this.originate(this.radars[0].lat, this.radars[0].lng, true);
    this.lay();
  }

  /** Takes a collection of tracks. @param {TrackCollection} collection */
  takeTracks(collection) {
    if (this.map.picture) return;
    const [first] = list(collection, "features");
    if (!first) return;
    this.originate(first.properties.lat, first.properties.lng, false);
    this.lay();
  }

  /**
   * Takes the coverage, or the cells of a cluster.
   * @param {"coverage" | "cells"} name @param {Collection} collection
   */
  takeShapes(name, collection) {
    list(collection, "features");
    this.shapes.set(name, collection);
    this.lay();
  }

  /** Takes the answer of /areas. @param {AreasAnswer} areas */
  takeAreas(areas) {
    list(areas, "features");
    this.areas = areas;
    this.lay();
  }

  /**
   * Takes the tiles of /info: {url, attribution} of raster tiles, {min_zoom, max_zoom, attribution} of the site's base map.
   * @param {Info} info
   */
  takeTiles({ tiles, basemap }) {
    if (tiles) this.tiles ??= new PictureTiles(tiles, (...came) => this.tileCame("tiles", ...came));
    if (basemap) this.base ??= new VectorTiles(basemap, (...came) => this.tileCame("base", ...came));
    this.lay();
  }

  /** Labels the zones with heights in the selected units. */
  nameZones() {
    const { map } = this;
    if (map.areas && map.picture) map.areas = map.areas.in(map.picture.frame);
  }

  /** @param {number} lat @param {number} lng @param {boolean} isRadar */
  originate(lat, lng, isRadar) {
    const { picture } = this.map;
    if (picture && (picture.frame.isRadar || !isRadar)) return; // the origin stays
    if (!Number.isFinite(lat) || !Number.isFinite(lng)) return;
    const frame = new Frame(lat, lng, isRadar);
    if (picture) this.map.reframe(frame);
    else this.began(new Picture(frame));
  }

  /** Draws known data that are not drawn yet. */
  lay() {
    const { map } = this;
    if (!map.picture) return;
    const { frame } = map.picture;
    map.radars = this.radars.map(({ id, lat, lng }) => {
      const [x, y] = frame.toLocal(lat, lng);
      return { id, x, y };
    });
    for (const [name, collection] of this.shapes) {
      if (map[name]?.geojson !== collection) map[name] = new Shapes(name, collection, frame);
    }
    if (this.areas && map.areas?.geojson !== this.areas) map.areas = new Zones(this.areas, frame);
    if (this.base) map.base ??= new Tiles(this.base, frame);
    if (this.tiles) map.tiles ??= new Tiles(this.tiles, frame);
    map.invalidate();
  }
}
