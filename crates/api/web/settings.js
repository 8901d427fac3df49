// Settings of the operator, kept in the URL's hash so that a link or a reload restores the view.

/** @type {Source[]} */
export const SOURCES = ["fused", "radar", "transponder", "camera"];

/** Layers, with the text of their switch and their default. */
export const LAYERS = /** @type {const} */ ({
  labels: ["Labels", true],
  trails: ["Trails", true],
  vectors: ["Where it will be in 10 s", true],
  ellipses: ["Uncertainty: where each is, 95 times of 100", false],
  rings: ["Range rings and bearings", true],
  coverage: ["Coverage of the sensors", true],
  areas: ["Zones", true],
  cells: ["Cells of the cluster", true],
  raw: ["Raw inputs: plots and transponder reports", false],
  base: ["Base map", true],
  tiles: ["Map tiles", true],
});
const LAYER_NAMES = namesOf(LAYERS);

export const TRAILS_S = [15, 30, 60, 120, 300];
/** Kinds of tracks, with their texts. */
export const KINDS = { identified: "identified", unknown: "radar or cameras only", doubtful: "hardly a drone" };
export const KIND_NAMES = namesOf(KINDS);
export const INTEGRITIES = ["verified", "unverified", "suspect", "failed", "uncooperative"];

/**
 * Conversion of a setting to and from text; null is not written.
 * @template T
 * @typedef {{ write: (value: T) => string | null, read: (text: string, usual: T) => T }} Codec
 */

/** @type {Codec<string>} */
const text = { write: (value) => value || null, read: (value) => value };
/** @type {Codec<boolean>} */
const flag = { write: (value) => (value ? "1" : null), read: (value) => value === "1" };
/** @type {Codec<number | null>} */
const number = { write: (value) => (value === null ? null : String(value)), read: (value) => (value !== "" && Number.isFinite(Number(value)) ? Number(value) : null) };
/** @type {<T extends string>(known: T[]) => Codec<T>} */
const oneOf = (known) => ({ write: (value) => value, read: (value, usual) => known.find((name) => name === value) ?? usual });
/** @type {<T extends string>(known: T[]) => Codec<Set<T>>} */
const some = (known) => ({
  write: (set) => [...set].join(","),
  read: (value) => new Set(value.split(",").flatMap((text) => known.filter((name) => name === text))),
});

const [HEIGHT, SPEED, DISTANCE] = [oneOf(["m", "ft", "FL", "m-agl", "ft-agl"]), oneOf(["m/s", "kt", "km/h"]), oneOf(["m", "nm"])];

/**
 * Settings: name in the hash, default, and conversion to and from text.
 * @type {{ [Name in keyof Settings]: [string, Settings[Name], Codec<Settings[Name]>] }}
 */
const FIELDS = {
  centre: ["c", null, { write: (value) => value && value.map((part) => part.toFixed(6)).join(","), read: readCentre }],
  scale: ["z", null, { write: (value) => value?.toPrecision(4) ?? null, read: (value) => (Number.parseFloat(value) > 0 && Number.isFinite(Number.parseFloat(value)) ? Number.parseFloat(value) : null) }],
  selected: ["s", null, { write: (value) => value || null, read: (value) => value }],
  follow: ["follow", false, flag],
  text: ["q", "", text],
  sources: ["src", new Set(SOURCES), some(SOURCES)],
  flagged: ["flagged", false, flag],
  low: ["low", null, number], // metres above mean sea level
  high: ["high", null, number],
  kinds: ["kind", new Set(KIND_NAMES), some(KIND_NAMES)],
  integrity: ["integrity", "", oneOf(["", ...INTEGRITIES])],
  zone: ["zone", "", text],
  watchedOnly: ["watched", false, flag],
  watched: ["watch", new Set(), { write: (set) => [...set].join(" ") || null, read: (value) => new Set(value.split(" ").filter(Boolean)) }],
  sort: ["sort", { column: "source", descending: false }, { write: ({ column, descending }) => (descending ? "-" : "") + column, read: (value) => ({ column: value.replace("-", ""), descending: value.startsWith("-") }) }],
  theme: ["theme", "auto", oneOf(["auto", "light", "dark"])],
  layers: ["layers", layersBy((name) => LAYERS[name][1]), { write: (layers) => LAYER_NAMES.filter((name) => layers[name]).join(","), read: readLayers }],
  labelBy: ["by", "name", oneOf(["name", "number", "serial"])],
  colourBy: ["colour", "source", oneOf(["source", "height"])],
  trailS: ["trail", 60, { write: String, read: (value, usual) => (TRAILS_S.includes(Number(value)) ? Number(value) : usual) }],
  units: ["units", { height: "m", speed: "m/s", distance: "m" }, { write: ({ height, speed, distance }) => [height, speed, distance].join(","), read: readUnits }],
  groundM: ["ground", null, number], // height of the ground above mean sea level, entered by the operator
  sound: ["sound", false, flag],
  at: ["at", "lagged", oneOf(["lagged", "now"])], // picture to show
};

/** Names of the members of an object. @template {string} K @param {Record<K, unknown>} object */
export function namesOf(object) {
  return /** @type {K[]} */ (Object.keys(object));
}

/** @param {(name: Layer) => boolean} isOn */
function layersBy(isOn) {
  return /** @type {Record<Layer, boolean>} */ (Object.fromEntries(LAYER_NAMES.map((name) => [name, isOn(name)])));
}

/** @param {string} value @returns {Point | null} */
function readCentre(value) {
  const [lat, lng, ...more] = value.split(",").map(Number.parseFloat);
  return !more.length && Number.isFinite(lat) && Number.isFinite(lng) && Math.abs(lat) <= 90 ? [lat, lng] : null;
}

/** @param {string} value */
function readLayers(value) {
  const named = value.split(",");
  return layersBy((name) => named.includes(name));
}

/** @param {string} value @param {Settings["units"]} usual @returns {Settings["units"]} */
function readUnits(value, usual) {
  const [height, speed, distance] = value.split(",");
  return {
    height: HEIGHT.read(height, usual.height),
    speed: SPEED.read(speed, usual.speed),
    distance: DISTANCE.read(distance, usual.distance),
  };
}

const NAMES = namesOf(FIELDS);
/** @type {Settings} */
const USUAL = Object.assign({}, ...NAMES.map((name) => ({ [name]: FIELDS[name][1] })));

export const settings = { ...USUAL };

/** @type {((patch: Partial<Settings>) => void)[]} */
const listeners = [];
/** @param {(patch: Partial<Settings>) => void} listener */
export const onChange = (listener) => listeners.push(listener);

/** @param {Partial<Settings>} patch */
export function change(patch) {
  Object.assign(settings, patch);
  for (const listener of listeners) listener(patch);
  writeLater();
}

/** @param {Layer} name */
export const toggleLayer = (name) => change({ layers: { ...settings.layers, [name]: !settings.layers[name] } });

/** A set with a value added or, if it was present, removed. @template T @param {Set<T>} set @param {T} value */
export function toggled(set, value) {
  const other = new Set(set);
  if (!other.delete(value)) other.add(value);
  return other;
}

/** @type {(keyof Settings)[]} */
const FILTERS = ["text", "sources", "flagged", "low", "high", "kinds", "integrity", "zone", "watchedOnly"];

/** Text of a setting in the hash. @type {<Name extends keyof Settings>(name: Name, all: Settings) => string | null} */
const written = (name, all) => FIELDS[name][2].write(all[name]);
/** @type {<Name extends keyof Settings>(name: Name, text: string) => Settings[Name]} */
const parsed = (name, text) => FIELDS[name][2].read(text, USUAL[name]);
export const isFiltering = () => FILTERS.some((name) => written(name, settings) !== written(name, USUAL));
/** @param {Partial<Settings>} patch */
export const isFilter = (patch) => FILTERS.some((name) => name in patch);
export const clearFilter = () => change(Object.fromEntries(FILTERS.map((name) => [name, USUAL[name]])));

/** @type {number | undefined} */
let timer;
// Browsers refuse frequent history entries, and a pan changes the centre at every frame.
function writeLater() {
  clearTimeout(timer);
  timer = setTimeout(write, 300);
}

function write() {
  const hash = new URLSearchParams();
  for (const name of NAMES) {
    const value = written(name, settings);
    if (value !== null && value !== written(name, USUAL)) hash.set(FIELDS[name][0], value);
  }
  history.replaceState(null, "", `#${hash.toString().replaceAll("%2C", ",")}`);
}

/** The hash may be edited by the user, so invalid parts are ignored. */
export function read() {
  const hash = new URLSearchParams(location.hash.slice(1));
  const patch = { ...USUAL };
  for (const name of NAMES) {
    const text = hash.get(FIELDS[name][0]);
    if (text !== null) Object.assign(patch, { [name]: parsed(name, text) });
  }
  change(patch);
}
