// What the picture stands on: the origin of its frame, the radars, coverage, areas and tiles.
// The origin is the first radar. For as long as none is known it is the first track, so that no track waits for the sensors.

import { list } from "./api.js";
import { Frame } from "./geo.js";
import { Picture } from "./picture.js";
import { Shapes } from "./shapes.js";
import { Tiles } from "./tiles.js";

export class Ground {
  radars = []; // {id, lat, lng}
  collections = new Map(); // GeoJSON by the name of its layer
  tiles = null; // as /info tells: {url, attribution}

  /** `began` is given the picture as soon as there is one; `tileCame`, whether the latest tiles come. */
  constructor(map, began, tileCame) {
    Object.assign(this, { map, began, tileCame });
  }

  /** The answer of /sensors. */
  takeSensors(collection) {
    this.radars = list(collection, "features")
      .filter(({ geometry, properties }) => properties.kind === "radar" && geometry?.type === "Point")
      .map(({ geometry: { coordinates: [lng, lat] }, properties: { id } }) => ({ id, lat, lng }));
    if (this.radars.length) this.originate(this.radars[0].lat, this.radars[0].lng, true);
    this.lay();
  }

  /** A collection of tracks. */
  takeTracks(collection) {
    if (this.map.picture) return;
    const [first] = list(collection, "features");
    if (!first) return;
    this.originate(first.properties.lat, first.properties.lng, false);
    this.lay();
  }

  /** The answer of /coverage or /areas. */
  takeShapes(name, collection) {
    list(collection, "features");
    this.collections.set(name, collection);
    this.lay();
  }

  takeTiles(tiles) {
    this.tiles = tiles;
    this.lay();
  }

  originate(lat, lng, isRadar) {
    const { picture } = this.map;
    if (picture && (picture.frame.isRadar || !isRadar)) return; // it stays where it is
    if (!Number.isFinite(lat) || !Number.isFinite(lng)) return;
    const frame = new Frame(lat, lng, isRadar);
    if (picture) this.map.reframe(frame);
    else this.began(new Picture(frame));
  }

  /** Draws what is known and not drawn yet. */
  lay() {
    const { map } = this;
    if (!map.picture) return;
    const { frame } = map.picture;
    map.radars = this.radars.map(({ id, lat, lng }) => {
      const [x, y] = frame.toLocal(lat, lng);
      return { id, x, y };
    });
    for (const [name, collection] of this.collections) {
      if (map[name]?.geojson !== collection) map[name] = new Shapes(name, collection, frame);
    }
    if (this.tiles && !map.tiles) map.tiles = new Tiles(this.tiles, frame, this.tileCame);
    map.invalidate();
  }
}
