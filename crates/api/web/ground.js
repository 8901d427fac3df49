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
  radars = []; // {id, lat, lng}
  collections = new Map(); // GeoJSON by layer name
  sources = new Map(); // sources of tiles, by layer name

  /**
   * `began` receives the picture as soon as there is one; `tileCame` receives a layer, and whether its latest tiles arrive or the
   * reason why not.
   */
  constructor(map, began, tileCame) {
    Object.assign(this, { map, began, tileCame });
  }

  /** Takes the answer of /sensors. */
  takeSensors(collection) {
    this.radars = list(collection, "features")
      .filter(({ geometry, properties }) => properties.kind === "radar" && geometry?.type === "Point")
      .map(({ geometry: { coordinates: [lng, lat] }, properties: { id } }) => ({ id, lat, lng }));
    if (this.radars.length) this.originate(this.radars[0].lat, this.radars[0].lng, true);
    this.lay();
  }

  /** Takes a collection of tracks. */
  takeTracks(collection) {
    if (this.map.picture) return;
    const [first] = list(collection, "features");
    if (!first) return;
    this.originate(first.properties.lat, first.properties.lng, false);
    this.lay();
  }

  /** Takes the answer of /coverage or /areas. */
  takeShapes(name, collection) {
    list(collection, "features");
    this.collections.set(name, collection);
    this.lay();
  }

  /** Takes the tiles of /info: {url, attribution} of raster tiles, {min_zoom, max_zoom, attribution} of the site's base map. */
  takeTiles({ tiles, basemap }) {
    const add = (name, what, Source) => {
      if (what && !this.sources.has(name)) this.sources.set(name, new Source(what, (isGood, why) => this.tileCame(name, isGood, why)));
    };
    add("tiles", tiles, PictureTiles);
    add("base", basemap, VectorTiles);
    this.lay();
  }

  /** Labels the zones with heights in the selected units. */
  nameZones() {
    const { map } = this;
    if (map.areas) map.areas = map.areas.in(map.picture.frame);
  }

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
    for (const [name, collection] of this.collections) {
      if (map[name]?.geojson === collection) continue;
      map[name] = name === "areas" ? new Zones(collection, frame) : new Shapes(name, collection, frame);
    }
    for (const [name, source] of this.sources) map[name] ??= new Tiles(source, frame);
    map.invalidate();
  }
}
