// The map page: takes the stream of events, and hands each to the part that shows it.

import { Alerts } from "./alerts.js";
import { get, onUnauthorized, setToken, Stream } from "./api.js";
import { Detail } from "./detail.js";
import { byId, element, setAttribute, setText } from "./dom.js";
import * as format from "./format.js";
import { bearing, Frame } from "./geo.js";
import { Keyboard } from "./keyboard.js";
import { Map2d } from "./map.js";
import { listenForOverlays } from "./overlays.js";
import { applyTheme, nextTheme, themeWords } from "./palette.js";
import { Picture } from "./picture.js";
import { Raw } from "./raw.js";
import { Replay } from "./replay.js";
import { Sensors } from "./sensors.js";
import { change, isFiltering, LAYERS, onChange, read, settings, toggleLayer, toggleSource } from "./settings.js";
import { Shapes } from "./shapes.js";
import { Status } from "./status.js";
import { Table } from "./table.js";
import { Tiles } from "./tiles.js";

const RENEW_MS = 10000; // rates, clock offsets and alerts that are over come by asking

read();
applyTheme();
const map = new Map2d(byId("canvas"), showCursor);
const table = new Table();
const detail = new Detail();
const status = new Status();
const replay = new Replay(status);
const alerts = new Alerts((byTrack) => {
  map.alerted = byTrack;
  map.invalidate();
});
const sensors = new Sensors(() => map.invalidate());
map.raw = new Raw(map);

// ── what the service says

let hasSensors = false;
let early = null; // a snapshot that came before the origin was known

/** The first radar is the origin; once it is known that there is none, the first track. */
function originate(lat, lng, isRadar) {
  if (map.picture || !Number.isFinite(lat) || !Number.isFinite(lng)) return;
  const picture = new Picture(new Frame(lat, lng, isRadar));
  [map.picture, table.picture, detail.picture] = [picture, picture, picture];
  if (early) picture.snapshot(early);
  early = null;
  lay(status.info?.tiles);
  map.frameOnce();
}

/** The tiles under the map, and the words that their makers ask for. */
function lay(tiles) {
  if (tiles && map.picture && !map.tiles) map.tiles = new Tiles(tiles, map.picture.frame, () => map.invalidate());
  setText(byId("attribution"), map.tiles?.attribution ?? "");
  byId("layer-list").querySelector("[name=tiles]").closest("li").hidden = !map.tiles;
}

function originateFromTracks({ features = [] }) {
  if (hasSensors && features.length) originate(features[0].properties.lat, features[0].properties.lng, false);
}

async function loadInfo() {
  const info = await get("info");
  status.info = info;
  detail.info = info;
  const site = typeof info.site === "object" ? info.site?.name : info.site;
  setText(byId("site"), site ?? "");
  document.title = site ? `${site} – utm-fusion` : "utm-fusion";
  byId("site").title = `version ${info.version ?? "?"}, profile ${info.profile ?? "?"}`;
  if (Number.isFinite(info.latency_s)) status.latency = info.latency_s;
  lay(info.tiles);
  if (status.isReplay) replay.update(info.replay ?? {});
}

async function loadSensors() {
  const collection = await get("sensors");
  sensors.replace(collection);
  const radars = (collection.features ?? [])
    .filter(({ geometry, properties }) => properties.kind === "radar" && geometry?.type === "Point")
    .map(({ geometry: { coordinates: [lng, lat] }, properties: { id } }) => ({ id, lat, lng }));
  if (radars.length) originate(radars[0].lat, radars[0].lng, true);
  hasSensors = true;
  map.radars = radars.map(({ id, lat, lng }) => {
    const [x, y] = map.picture.frame.toLocal(lat, lng);
    return { id, x, y };
  });
  map.invalidate();
}

async function loadShapes() {
  for (const name of ["coverage", "areas"]) {
    const collection = await get(name);
    if (map.picture) map[name] = new Shapes(name, collection, map.picture.frame);
  }
  map.frameOnce();
  map.invalidate();
}

const loadAlerts = async () => alerts.replace(await get("alerts"));

/** Each alone: a part that fails must not keep the others from the operator. */
async function load(...parts) {
  for (const part of parts) await part().catch(() => {});
}

let chosen = null; // the selected track as it was last

/** Where the selected track has ended and its aircraft goes on under another id, the selection goes with the aircraft. */
function keepSelection() {
  const track = map.picture?.tracks.get(settings.selected);
  if (track) {
    chosen = track;
  } else if (chosen) {
    const heir = map.picture.heirOf(chosen);
    if (heir) change({ selected: heir.id });
  }
}

function took(collection) {
  status.heard(collection);
  keepSelection();
  if (!map.framed) map.frameOnce();
  if (status.isReplay) replay.at(Date.parse(collection.time));
  map.invalidate();
}

function start() {
  const stream = new Stream({
    opened: () => load(loadInfo, loadSensors, loadShapes, loadAlerts),
    failed: (wait) => (status.retry = wait),
    snapshot(collection) {
      originateFromTracks(collection);
      if (map.picture) map.picture.snapshot(collection);
      else early = collection;
      took(collection);
      table.refresh();
    },
    tracks(collection) {
      originateFromTracks(collection);
      map.picture?.update(collection);
      took(collection);
    },
    ended({ ids = [] }) {
      status.heard({});
      map.picture?.end(ids);
      keepSelection();
      map.invalidate();
    },
    sensor(properties) {
      status.heard({});
      sensors.update(properties);
    },
    alert(alert) {
      status.heard({});
      alerts.update(alert);
    },
    heartbeat: (beat) => status.beat(beat),
    // A snapshot of the tracks follows: what was missed is in it.
    resync() {
      status.heard({});
      load(loadSensors, loadAlerts);
    },
  });
  setInterval(() => load(loadInfo, loadSensors, loadAlerts), RENEW_MS);
  return stream;
}

// ── what the operator does

function showCursor(px, py) {
  const readout = byId("readout");
  if (px == null || !map.picture) return setText(readout, "");
  const [x, y] = map.view.toLocal(px, py);
  const { frame } = map.picture;
  const about = frame.isRadar ? `${bearing(x, y).toFixed(1).padStart(5, "0")}°  ${format.distance(Math.hypot(x, y))}  ` : "";
  setText(readout, about + format.position(...frame.toGeodetic(x, y)));
}

function showFilter() {
  byId("filtered").hidden = !isFiltering();
  if (!isFiltering() || !map.picture) return;
  setText(byId("filtered-text"), `Filtered: ${map.picture.visible().length} of ${map.picture.tracks.size} tracks shown`);
}

const clearFilter = () => change({ text: "", sources: new Set(Object.keys(SOURCE_BUTTONS)) });
const SOURCE_BUTTONS = Object.fromEntries([...byId("sources").children].map((button) => [button.dataset.source, button]));

function showSettings() {
  const { text, sources, layers, labelBy, follow, selected } = settings;
  if (byId("filter-input").value !== text) byId("filter-input").value = text;
  for (const [source, button] of Object.entries(SOURCE_BUTTONS)) setAttribute(button, "aria-pressed", String(sources.has(source)));
  for (const box of byId("layer-list").querySelectorAll("input")) box.checked = layers[box.name];
  byId("label-by").value = labelBy;
  setAttribute(byId("follow"), "aria-pressed", String(follow && Boolean(selected)));
  setText(byId("theme-button"), `◐ ${settings.theme}`);
  setAttribute(byId("theme-button"), "aria-label", `Theme: ${themeWords()}`);
  showFilter();
}

function listen() {
  for (const [name, [words]] of Object.entries(LAYERS)) {
    const box = element("input", { type: "checkbox", name });
    box.addEventListener("change", () => toggleLayer(name));
    byId("layer-list").append(element("li", {}, element("label", {}, box, words)));
  }
  byId("label-by").addEventListener("change", (event) => change({ labelBy: event.target.value }));
  byId("filter").addEventListener("submit", (event) => event.preventDefault());
  byId("filter-input").addEventListener("input", (event) => change({ text: event.target.value.trim() }));
  for (const [source, button] of Object.entries(SOURCE_BUTTONS)) button.addEventListener("click", () => toggleSource(source));
  byId("filter-clear").addEventListener("click", clearFilter);
  byId("zoom-in").addEventListener("click", () => map.zoom(1.5));
  byId("zoom-out").addEventListener("click", () => map.zoom(1 / 1.5));
  byId("fit").addEventListener("click", () => map.fit());
  byId("follow").addEventListener("click", toggleFollow);
  byId("theme-button").addEventListener("click", () => change({ theme: nextTheme() }));
  byId("help-button").addEventListener("click", () => byId("help").showModal());
  addEventListener("hashchange", () => {
    read();
    map.framed = false;
    map.frameOnce();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    applyTheme();
    map.invalidate();
  });
}

const toggleFollow = () => change({ follow: !settings.follow && settings.selected !== null });

function escape() {
  if (document.querySelector("dialog[open], :popover-open")) return; // the browser closes those
  if (document.activeElement === byId("filter-input")) byId("filter-input").blur();
  else change({ selected: null, follow: false });
}

onChange((patch) => {
  if ("theme" in patch) applyTheme();
  if ("selected" in patch) {
    chosen = map.picture?.tracks.get(settings.selected) ?? null;
    detail.refresh();
  }
  showSettings();
  map.invalidate();
});

onUnauthorized(() => {
  if (!byId("sign-in").open) byId("sign-in").showModal();
});
byId("sign-in-form").addEventListener("submit", () => {
  setToken(byId("token").value);
  byId("token").value = "";
  load(loadInfo, loadSensors, loadShapes, loadAlerts); // the stream tries again by itself
});

listen();
listenForOverlays(map);
new Keyboard([
  [["+", "="], "Zoom in", () => map.zoom(1.5)],
  [["-", "_"], "Zoom out", () => map.zoom(1 / 1.5)],
  [["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"], "Pan the map; in the table, select", ({ key }) => {
    const [dx, dy] = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[key];
    map.pan(dx, dy);
  }],
  [["0"], "Show all tracks", () => map.fit()],
  [["f"], "Follow the selected track", toggleFollow],
  [["/"], "Filter", () => byId("filter-input").focus()],
  [["l"], "Labels", () => toggleLayer("labels")],
  [["r"], "Range rings and bearings", () => toggleLayer("rings")],
  [["v"], "Where each will be in 10 s", () => toggleLayer("vectors")],
  [["a"], "Alerts", () => alerts.open(byId("alerts").hidden)],
  [["t"], "Theme: auto, light, dark", () => change({ theme: nextTheme() })],
  [[" "], "Replay: play or pause", () => status.isReplay && replay.toggle()],
  [["?"], "This help", () => byId("help").showModal()],
  [["Escape"], "Close, or select nothing", escape],
]);
showSettings();
setInterval(showFilter, 1000);
load(loadInfo, loadSensors).then(start); // the rest when the stream is open, and anew whenever it opens again
