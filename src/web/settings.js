// What the operator chose, kept in the URL's hash so that a link or a reload brings the same view back.

export const SOURCES = ["fused", "radar", "transponder"];

/** The layers that can be switched, with the text of their switch and whether they are on at first. */
export const LAYERS = {
  labels: ["Labels", true],
  trails: ["Trails of 60 s", true],
  vectors: ["Where it will be in 10 s", true],
  rings: ["Range rings and bearings", true],
  coverage: ["Coverage of the sensors", true],
  areas: ["Areas", true],
  raw: ["Raw inputs: plots and transponder reports", false],
  tiles: ["Map tiles", true],
};

const defaultLayers = () => Object.fromEntries(Object.entries(LAYERS).map(([name, [, isOn]]) => [name, isOn]));

export const settings = {
  centre: null, // [lat, lng]
  scale: null, // pixels a metre
  selected: null,
  follow: false,
  text: "",
  sources: new Set(SOURCES),
  flagged: false, // only what cannot be trusted
  sort: { column: "number", descending: false },
  theme: "auto",
  layers: defaultLayers(),
  labelBy: "number",
  at: "lagged", // or "now": which of the service's pictures is shown
};

const listeners = [];
export const onChange = (listener) => listeners.push(listener);

export function change(patch) {
  Object.assign(settings, patch);
  for (const listener of listeners) listener(patch);
  writeLater();
}

export const toggleLayer = (name) => change({ layers: { ...settings.layers, [name]: !settings.layers[name] } });

export function toggleSource(source) {
  const sources = new Set(settings.sources);
  if (!sources.delete(source)) sources.add(source);
  change({ sources });
}

export const isFiltering = () => settings.text !== "" || settings.flagged || settings.sources.size < SOURCES.length;

let timer = null;
// Browsers refuse many history entries a second; a pan changes the centre at every frame.
function writeLater() {
  clearTimeout(timer);
  timer = setTimeout(write, 300);
}

function write() {
  const hash = new URLSearchParams();
  if (settings.centre) hash.set("c", settings.centre.map((value) => value.toFixed(6)).join(","));
  if (settings.scale) hash.set("z", settings.scale.toPrecision(4));
  if (settings.selected) hash.set("s", settings.selected);
  if (settings.follow) hash.set("follow", "1");
  if (settings.text) hash.set("q", settings.text);
  if (settings.sources.size < SOURCES.length) hash.set("src", [...settings.sources].join(","));
  if (settings.flagged) hash.set("flagged", "1");
  const sort = (settings.sort.descending ? "-" : "") + settings.sort.column;
  if (sort !== "number") hash.set("sort", sort);
  if (settings.theme !== "auto") hash.set("theme", settings.theme);
  if (settings.labelBy !== "number") hash.set("by", settings.labelBy);
  if (settings.at !== "lagged") hash.set("at", settings.at);
  const layers = Object.keys(LAYERS).filter((name) => settings.layers[name]);
  if (Object.keys(LAYERS).some((name) => settings.layers[name] !== LAYERS[name][1])) hash.set("layers", layers.join(","));
  history.replaceState(null, "", `#${hash.toString().replaceAll("%2C", ",")}`);
}

/** The hash is the user's text: anything that makes no sense is as if it were not there. */
export function read() {
  const hash = new URLSearchParams(location.hash.slice(1));
  const centre = (hash.get("c") ?? "").split(",").map(Number.parseFloat);
  const scale = Number.parseFloat(hash.get("z"));
  const sort = hash.get("sort") ?? "number";
  change({
    centre: centre.length === 2 && centre.every(Number.isFinite) && Math.abs(centre[0]) <= 90 ? centre : null,
    scale: scale > 0 && Number.isFinite(scale) ? scale : null,
    selected: hash.get("s"),
    follow: hash.get("follow") === "1",
    text: hash.get("q") ?? "",
    sources: new Set(hash.has("src") ? hash.get("src").split(",").filter((name) => SOURCES.includes(name)) : SOURCES),
    flagged: hash.get("flagged") === "1",
    sort: { column: sort.replace("-", ""), descending: sort.startsWith("-") },
    theme: ["light", "dark"].includes(hash.get("theme")) ? hash.get("theme") : "auto",
    labelBy: hash.get("by") === "serial" ? "serial" : "number",
    at: hash.get("at") === "now" ? "now" : "lagged",
    layers: hash.has("layers")
      ? Object.fromEntries(Object.keys(LAYERS).map((name) => [name, hash.get("layers").split(",").includes(name)]))
      : defaultLayers(),
  });
}
