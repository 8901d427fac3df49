// Settings of the operator, kept in the URL's hash so that a link or a reload restores the view.

export const SOURCES = ["fused", "radar", "transponder"];

/** Layers, with the text of their switch and their default. */
export const LAYERS = {
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
};

export const TRAILS_S = [15, 30, 60, 120, 300];
/** Kinds of tracks, with their texts. */
export const KINDS = { identified: "identified", unknown: "radar only", doubtful: "hardly a drone" };
export const INTEGRITIES = ["verified", "unverified", "suspect", "failed", "uncooperative"];

const text = { write: (value) => value || null, read: (value) => value };
const flag = { write: (value) => (value ? "1" : null), read: (value) => value === "1" };
const number = { write: (value) => (value === null ? null : String(value)), read: (value) => (value !== "" && Number.isFinite(Number(value)) ? Number(value) : null) };
const oneOf = (known) => ({ write: (value) => value, read: (value, usual) => (known.includes(value) ? value : usual) });
const some = (known) => ({ write: (set) => [...set].join(","), read: (value) => new Set(value.split(",").filter((name) => known.includes(name))) });

/** Settings: name in the hash, default, and conversion to and from text. Null is not written. */
const FIELDS = {
  centre: ["c", null, { write: (value) => value && value.map((part) => part.toFixed(6)).join(","), read: readCentre }],
  scale: ["z", null, { write: (value) => value && value.toPrecision(4), read: (value) => (Number.parseFloat(value) > 0 && Number.isFinite(Number.parseFloat(value)) ? Number.parseFloat(value) : null) }],
  selected: ["s", null, text],
  follow: ["follow", false, flag],
  text: ["q", "", text],
  sources: ["src", new Set(SOURCES), some(SOURCES)],
  flagged: ["flagged", false, flag],
  low: ["low", null, number], // metres above mean sea level
  high: ["high", null, number],
  kinds: ["kind", new Set(Object.keys(KINDS)), some(Object.keys(KINDS))],
  integrity: ["integrity", "", oneOf(["", ...INTEGRITIES])],
  zone: ["zone", "", text],
  watchedOnly: ["watched", false, flag],
  watched: ["watch", new Set(), { write: (set) => [...set].join(" ") || null, read: (value) => new Set(value.split(" ").filter(Boolean)) }],
  sort: ["sort", { column: "source", descending: false }, { write: ({ column, descending }) => (descending ? "-" : "") + column, read: (value) => ({ column: value.replace("-", ""), descending: value.startsWith("-") }) }],
  theme: ["theme", "auto", oneOf(["auto", "light", "dark"])],
  layers: ["layers", usualLayers(), { write: (layers) => Object.keys(LAYERS).filter((name) => layers[name]).join(","), read: readLayers }],
  labelBy: ["by", "name", oneOf(["name", "number", "serial"])],
  colourBy: ["colour", "source", oneOf(["source", "height"])],
  trailS: ["trail", 60, { write: String, read: (value, usual) => (TRAILS_S.includes(Number(value)) ? Number(value) : usual) }],
  units: ["units", { height: "m", speed: "m/s", distance: "m" }, { write: ({ height, speed, distance }) => [height, speed, distance].join(","), read: readUnits }],
  groundM: ["ground", null, number], // height of the ground above mean sea level, entered by the operator
  sound: ["sound", false, flag],
  at: ["at", "lagged", oneOf(["lagged", "now"])], // picture to show
};

function usualLayers() {
  return Object.fromEntries(Object.entries(LAYERS).map(([name, [, isOn]]) => [name, isOn]));
}

function readCentre(value) {
  const centre = value.split(",").map(Number.parseFloat);
  return centre.length === 2 && centre.every(Number.isFinite) && Math.abs(centre[0]) <= 90 ? centre : null;
}

function readLayers(value) {
  const named = value.split(",");
  return Object.fromEntries(Object.keys(LAYERS).map((name) => [name, named.includes(name)]));
}

function readUnits(value, usual) {
  const [height, speed, distance] = value.split(",");
  const among = (known, value, usual) => (known.includes(value) ? value : usual);
  return {
    height: among(["m", "ft", "FL", "m-agl", "ft-agl"], height, usual.height),
    speed: among(["m/s", "kt", "km/h"], speed, usual.speed),
    distance: among(["m", "nm"], distance, usual.distance),
  };
}

const usual = () => Object.fromEntries(Object.entries(FIELDS).map(([name, [, value]]) => [name, value]));

export const settings = usual();

const listeners = [];
export const onChange = (listener) => listeners.push(listener);

export function change(patch) {
  Object.assign(settings, patch);
  for (const listener of listeners) listener(patch);
  writeLater();
}

export const toggleLayer = (name) => change({ layers: { ...settings.layers, [name]: !settings.layers[name] } });

/** A set with a value added or, if it was present, removed. */
export function toggled(set, value) {
  const other = new Set(set);
  if (!other.delete(value)) other.add(value);
  return other;
}

const FILTERS = ["text", "sources", "flagged", "low", "high", "kinds", "integrity", "zone", "watchedOnly"];

const written = (name, value = settings[name]) => FIELDS[name][2].write(value);
export const isFiltering = () => FILTERS.some((name) => written(name) !== written(name, FIELDS[name][1]));
export const isFilter = (patch) => FILTERS.some((name) => name in patch);
export const clearFilter = () => change(Object.fromEntries(FILTERS.map((name) => [name, FIELDS[name][1]])));

let timer = null;
// Browsers refuse frequent history entries, and a pan changes the centre at every frame.
function writeLater() {
  clearTimeout(timer);
  timer = setTimeout(write, 300);
}

function write() {
  const hash = new URLSearchParams();
  for (const [name, [key, first]] of Object.entries(FIELDS)) {
    const value = written(name);
    if (value !== null && value !== written(name, first)) hash.set(key, value);
  }
  history.replaceState(null, "", `#${hash.toString().replaceAll("%2C", ",")}`);
}

/** The hash may be edited by the user, so invalid parts are ignored. */
export function read() {
  const hash = new URLSearchParams(location.hash.slice(1));
  const patch = usual();
  for (const [name, [key, first, { read }]] of Object.entries(FIELDS)) if (hash.has(key)) patch[name] = read(hash.get(key), first);
  change(patch);
}
