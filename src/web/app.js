// The map page: takes what the service says, and hands each to the part that shows it.

import { Alerts } from "./alerts.js";
import { get, list, onUnauthorized, setToken, Stream } from "./api.js";
import { Detail } from "./detail.js";
import { byId, element, setAttribute, setText } from "./dom.js";
import { showFailures } from "./failures.js";
import * as format from "./format.js";
import { bearing } from "./geo.js";
import { Ground } from "./ground.js";
import { Keyboard } from "./keyboard.js";
import { Map2d } from "./map.js";
import { listenForOverlays } from "./overlays.js";
import { applyTheme, nextTheme } from "./palette.js";
import { Raw } from "./raw.js";
import { Reads } from "./reads.js";
import { Replay } from "./replay.js";
import { Sensors } from "./sensors.js";
import { change, isFiltering, LAYERS, onChange, read, settings, toggleLayer, toggleSource } from "./settings.js";
import { Status } from "./status.js";
import { Table } from "./table.js";

const RENEW_MS = 10000; // rates, clock offsets and alerts that are over come by asking
const RAW_MS = 1000;
const FRAME_MS = 2000; // the first view waits at most this long for the radars' places, which belong in it

read();
applyTheme();
const map = new Map2d(byId("canvas"), showCursor);
const status = new Status();
let stream = null; // until the page has begun
const table = new Table(isPictureKnown);
const detail = new Detail();
const replay = new Replay(status);
const alerts = new Alerts((byTrack) => {
  map.alerted = byTrack;
  map.invalidate();
});
const sensors = new Sensors(() => map.invalidate());
map.raw = new Raw(map);

// ── what the service says

const reads = new Reads(showKnown);
const ground = new Ground(
  map,
  (picture) => {
    [map.picture, table.picture, detail.picture] = [picture, picture, picture];
  },
  (came) => {
    map.invalidate();
    if (came) reads.good("tiles");
    else reads.failed("tiles", "their server does not send them");
  },
);

reads.add("tracks", "Tracks"); // by the stream
reads.add("info", "Service", { ask: () => get("info"), take: takeInfo, everyMs: RENEW_MS });
reads.add("sensors", "Sensors", { ask: () => get("sensors"), take: takeSensors, everyMs: RENEW_MS });
reads.add("alerts", "Alerts", { ask: () => get("alerts"), take: (answer) => alerts.replace(answer), everyMs: RENEW_MS });
reads.add("integrity", "Integrity", { ask: () => get("integrity"), take: (answer) => detail.verdicts.replace(list(answer, "identities")) });
for (const [name, title] of [["coverage", "Coverage"], ["areas", "Areas"]]) {
  reads.add(name, title, { ask: () => get(name), take: (answer) => takeShapes(name, answer) });
}
reads.add("raw", "Raw inputs", { ask: () => map.raw.ask(), take: (answer) => map.raw.take(answer), everyMs: RAW_MS, isWanted: () => map.raw.isWanted });
reads.add("tiles", "Map tiles");
reads.add("page", "This page");

/** Each part that counts or lists something says whether that is known. */
function showKnown() {
  showFailures(reads.failures());
  alerts.setRead(reads.all.get("alerts"));
  sensors.setRead(reads.all.get("sensors"));
  table.refresh();
  frameOnce();
}

function isPictureKnown() {
  return reads.state("tracks") === "good" && !status.isStale && Number.isFinite(status.pictureTime);
}

function takeInfo(info) {
  if (typeof info?.profile !== "string") throw new Error("the answer has no profile");
  status.info = info;
  detail.info = info;
  const site = typeof info.site === "object" ? info.site?.name : info.site;
  setText(byId("site"), site ?? "");
  alerts.site = site ?? "";
  alerts.showTitle();
  byId("site").title = `version ${info.version ?? "?"}, profile ${info.profile}`;
  if (Number.isFinite(info.latency_s) && !status.isNow) status.latency = info.latency_s;
  if (info.now !== true && settings.at !== "lagged") change({ at: "lagged" });
  ground.takeTiles(info.tiles);
  setText(byId("attribution"), info.tiles?.attribution ?? "");
  byId("layer-list").querySelector("[name=tiles]").closest("li").hidden = !info.tiles;
  if (status.isReplay) replay.update(info.replay ?? {});
}

function takeSensors(collection) {
  ground.takeSensors(collection);
  sensors.replace(collection);
}

function takeShapes(name, collection) {
  ground.takeShapes(name, collection);
  frameOnce();
}

function frameOnce() {
  if (reads.state("sensors") !== "unknown" || performance.now() >= FRAME_MS) map.frameOnce();
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
  status.took(collection);
  keepSelection();
  frameOnce();
  if (status.isReplay) replay.at(Date.parse(collection.time));
  map.invalidate();
}

function start() {
  return new Stream(settings.at, {
    // What was missed meanwhile is in no event.
    opened: () => reads.renew("info", "sensors", "alerts", "integrity", "coverage", "areas"),
    failed(wait, why) {
      status.failed(wait);
      reads.failed("tracks", why);
    },
    snapshot(collection) {
      ground.takeTracks(collection);
      map.picture?.snapshot(collection);
      status.began();
      took(collection);
      reads.good("tracks");
      table.refresh();
    },
    tracks(collection) {
      ground.takeTracks(collection);
      map.picture?.update(collection);
      took(collection);
    },
    ended(event) {
      status.heard({});
      map.picture?.end(list(event, "ids"));
      keepSelection();
      map.invalidate();
    },
    sensor(properties) {
      status.heard({});
      sensors.update(properties);
    },
    integrity(one) {
      status.heard({});
      detail.verdicts.note(one);
    },
    alert(alert) {
      status.heard({});
      alerts.update(alert);
    },
    heartbeat: (beat) => status.beat(beat),
    // A snapshot of the tracks follows: what was missed is in it.
    resync() {
      status.heard({});
      reads.renew("sensors", "alerts", "integrity");
    },
  });
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
  const total = isPictureKnown() ? map.picture.tracks.size : "?";
  setText(byId("filtered-text"), `Filtered: ${map.picture.visible().length} of ${total} tracks shown`);
}

const clearFilter = () => change({ text: "", flagged: false, sources: new Set(Object.keys(SOURCE_BUTTONS)) });
const SOURCE_BUTTONS = Object.fromEntries([...byId("sources").children].map((button) => [button.dataset.source, button]));

function showSettings() {
  const { text, sources, flagged, layers, labelBy, follow, selected } = settings;
  if (byId("filter-input").value !== text) byId("filter-input").value = text;
  for (const [source, button] of Object.entries(SOURCE_BUTTONS)) setAttribute(button, "aria-pressed", String(sources.has(source)));
  for (const box of byId("layer-list").querySelectorAll("input")) box.checked = layers[box.name];
  setAttribute(byId("flagged"), "aria-pressed", String(flagged));
  byId("label-by").value = labelBy;
  setAttribute(byId("follow"), "aria-pressed", String(follow && Boolean(selected)));
  setText(byId("theme-name"), settings.theme);
  showFilter();
}

function listen() {
  for (const [name, [words]] of Object.entries(LAYERS)) {
    const box = element("input", { type: "checkbox", name });
    box.addEventListener("change", () => toggleLayer(name));
    byId("layer-list").append(element("li", { hidden: name === "tiles" }, element("label", {}, box, words)));
  }
  byId("label-by").addEventListener("change", (event) => change({ labelBy: event.target.value }));
  byId("filter").addEventListener("submit", (event) => event.preventDefault());
  byId("filter-input").addEventListener("input", (event) => change({ text: event.target.value.trim() }));
  for (const [source, button] of Object.entries(SOURCE_BUTTONS)) button.addEventListener("click", () => toggleSource(source));
  byId("flagged").addEventListener("click", () => change({ flagged: !settings.flagged }));
  byId("filter-clear").addEventListener("click", clearFilter);
  byId("zoom-in").addEventListener("click", () => map.zoom(1.5));
  byId("zoom-out").addEventListener("click", () => map.zoom(1 / 1.5));
  byId("fit").addEventListener("click", () => map.fit());
  byId("follow").addEventListener("click", toggleFollow);
  byId("theme-button").addEventListener("click", () => change({ theme: nextTheme() }));
  byId("more-button").addEventListener("click", (event) => openMenu(event.target.getAttribute("aria-expanded") !== "true"));
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

/** Where every track is by now, or the picture in which late measurements still count. */
function toggleNow() {
  if (status.info?.now === true) change({ at: settings.at === "now" ? "lagged" : "now" });
}

const toggleFollow = () => change({ follow: !settings.follow && settings.selected !== null });

/** On a small screen the clock, the sensors and the tools are behind a button. */
function openMenu(isOpen) {
  setAttribute(byId("more-button"), "aria-expanded", String(isOpen));
  byId("more").classList.toggle("is-open", isOpen);
}

function escape() {
  if (document.querySelector("dialog[open], :popover-open")) return; // the browser closes those
  openMenu(false);
  if (document.activeElement === byId("filter-input")) byId("filter-input").blur();
  else change({ selected: null, follow: false });
}

onChange((patch) => {
  if ("theme" in patch) applyTheme();
  if ("at" in patch) stream?.show(settings.at);
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
  reads.renew("info", "sensors", "alerts", "integrity", "coverage", "areas"); // the stream tries again by itself
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
  [["n"], "Now: where each is predicted to be", toggleNow],
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
for (const kind of ["error", "unhandledrejection"]) {
  addEventListener(kind, () => reads.failed("page", "an error in it; load it anew"));
}
setTimeout(frameOnce, FRAME_MS);
reads.renew("info", "sensors");
stream = start();
