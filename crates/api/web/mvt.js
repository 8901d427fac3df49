// Decoder of vector tiles (Mapbox Vector Tile 2.1): protocol buffers of layers, from which names, geometry and attributes are
// read.

const text = new TextDecoder();
const [POINT, LINE, POLYGON] = [1, 2, 3];
const [MOVE, DRAW, CLOSE] = [1, 2, 7];

/** @typedef {"point" | "line" | "polygon"} Shape */
/** @typedef {string | number | boolean | null} Value */
/** @typedef {{ kind: Shape, parts: number[][], attributes: Record<string, Value> }} DecodedFeature */
/** @typedef {{ name: string, extent: number, features: DecodedFeature[] }} DecodedLayer */

/** @type {Record<number, Shape | undefined>} */
const SHAPES = { [POINT]: "point", [LINE]: "line", [POLYGON]: "polygon" };

/** The octets of a field. Throws if it has a number. @param {number | Uint8Array} value */
function octetsOf(value) {
  if (typeof value === "number") throw new Error("not a vector tile");
  return value;
}

/** The number of a field. Throws if it has octets. @param {number | Uint8Array} value */
function numberOf(value) {
  if (typeof value !== "number") throw new Error("not a vector tile");
  return value;
}

/** Fields of a protocol buffer, in sequence. A length beyond the end is an error. */
class Fields {
  /** @param {Uint8Array} octets */
  constructor(octets) {
    this.octets = octets;
    this.at = 0;
  }

  /** @returns {Generator<[number, number | Uint8Array], void>} */
  *[Symbol.iterator]() {
    while (this.at < this.octets.length) {
      const key = this.varint();
      const kind = key & 7;
      if (kind === 0) yield [key >>> 3, this.varint()];
      else if (kind === 1) yield [key >>> 3, this.take(8)];
      else if (kind === 2) yield [key >>> 3, this.take(this.varint())];
      else if (kind === 5) yield [key >>> 3, this.take(4)];
      else throw new Error("not a vector tile");
    }
  }

  varint() {
    let [value, factor] = [0, 1];
    for (;;) {
      if (this.at >= this.octets.length || factor > 2 ** 63) throw new Error("not a vector tile");
      const octet = this.octets[this.at++];
      value += (octet & 127) * factor;
      if (octet < 128) return value;
      factor *= 128;
    }
  }

  /** @param {number} length */
  take(length) {
    if (this.at + length > this.octets.length) throw new Error("not a vector tile");
    return this.octets.subarray(this.at, (this.at += length));
  }

  /** @param {Uint8Array} octets */
  static integers(octets) {
    const packed = new Fields(octets);
    const values = [];
    while (packed.at < octets.length) values.push(packed.varint());
    return values;
  }
}

/**
 * Decodes the layers selected by `wants(name)`: {name, extent, features}, each feature {kind, parts, attributes}. `kind` is
 * "point", "line" or "polygon"; `parts` are lists of [x, y, x, y, ...] within the tile's `extent`, y downwards.
 * @param {Uint8Array} octets @param {(name: string) => boolean} wants
 */
export function decode(octets, wants) {
  const layers = [];
  for (const [field, value] of new Fields(octets)) if (field === 3) layers.push(layerOf(octetsOf(value), wants));
  return layers.filter((layer) => layer !== null);
}

/** @param {Uint8Array} octets @param {(name: string) => boolean} wants */
function layerOf(octets, wants) {
  let [name, extent] = ["", 4096];
  /** @type {string[]} */
  const keys = [];
  /** @type {Value[]} */
  const values = [];
  const features = [];
  for (const [field, value] of new Fields(octets)) {
    if (field === 1) name = text.decode(octetsOf(value));
    else if (field === 2) features.push(octetsOf(value));
    else if (field === 3) keys.push(text.decode(octetsOf(value)));
    else if (field === 4) values.push(valueOf(octetsOf(value)));
    else if (field === 5) extent = numberOf(value);
  }
  if (!wants(name)) return null;
  return { name, extent, features: features.map((feature) => featureOf(feature, keys, values)).filter((feature) => feature !== null) };
}

/** Texts and whole numbers, as used in classes and names of maps; other values are null. @param {Uint8Array} octets */
function valueOf(octets) {
  for (const [field, value] of new Fields(octets)) {
    if (field === 1) return text.decode(octetsOf(value));
    if (field === 4 || field === 5) return numberOf(value);
    if (field === 6) return unzigzag(numberOf(value));
    if (field === 7) return value !== 0;
  }
  return null;
}

/** @param {Uint8Array} octets @param {string[]} keys @param {Value[]} values */
function featureOf(octets, keys, values) {
  let kind = 0;
  /** @type {number[]} */
  let geometry = [];
  /** @type {number[]} */
  let tags = [];
  for (const [field, value] of new Fields(octets)) {
    if (field === 2) tags = Fields.integers(octetsOf(value));
    else if (field === 3) kind = numberOf(value);
    else if (field === 4) geometry = Fields.integers(octetsOf(value));
  }
  const shape = SHAPES[kind];
  if (!shape) return null;
  /** @type {DecodedFeature["attributes"]} */
  const attributes = {};
  for (let i = 0; i + 1 < tags.length; i += 2) attributes[keys[tags[i]]] = values[tags[i + 1]];
  return { kind: shape, parts: partsOf(geometry), attributes };
}

/** @param {number} value */
const unzigzag = (value) => (value % 2 ? -(value + 1) / 2 : value / 2);

/** Geometry commands, each with a repeat count, and the steps between points. @param {number[]} geometry */
function partsOf(geometry) {
  const parts = [];
  let [x, y, at] = [0, 0, 0];
  while (at < geometry.length) {
    const [command, count] = [geometry[at] & 7, geometry[at] >>> 3];
    at += 1;
    if (command === CLOSE) continue; // rings of polygons are always closed
    if (command !== MOVE && command !== DRAW) throw new Error("not a vector tile");
    for (let i = 0; i < count && at + 1 < geometry.length; i++, at += 2) {
      x += unzigzag(geometry[at]);
      y += unzigzag(geometry[at + 1]);
      if (command === MOVE) parts.push([x, y]);
      else parts.at(-1)?.push(x, y);
    }
  }
  return parts;
}
