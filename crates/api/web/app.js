// The map page: receives data from the service, and passes them to the parts that show them.

import { ActiveZones } from "./activezones.js";
import { Alerts } from "./alerts.js";
import { get, list, Stream } from "./api.js";
import { offerLayer } from "./choices.js";
import { Conflicts } from "./conflicts.js";
import { Detail } from "./detail.js";
import { byId, setText } from "./dom.js";
import { showFailures } from "./failures.js";
import { takeZones } from "./filter.js";
import { Ground } from "./ground.js";
import { Map2d } from "./map.js";
import { Operator } from "./operator.js";
import { applyTheme } from "./palette.js";
import { Past } from "./past.js";
import { Raw } from "./raw.js";
import { Reads } from "./reads.js";
import { Replay } from "./replay.js";
import { Sensors } from "./sensors.js";
import { Cluster } from "./cluster.js";
import { change, onChange, read, settings } from "./settings.js";
import { Status } from "./status.js";
import { Table } from "./table.js";
import { noteBaseMap, welcome } from "./welcome.js";

const RENEW_MS = 10000; // rates, clock offsets and ended alerts are polled
const RAW_MS = 1000;
const CLUSTER_MS = 2000;
const STATE_MS = 2000; // state of the service, and its clock
const CONFLICTS_MS = 1000; // interval of their computation
const [MIN_ZONES_MS, MOST_ZONES_MS] = [1000, 86400000]; // limits of the time between two requests for the zones
const FRAME_MS = 2000; // maximum time for which the first view waits for the positions of the radars

read();
applyTheme();
const map = new Map2d(byId("canvas"));
const status = new Status(() => reads.renew("state"));
const table = new Table(isPictureKnown, () => status.whyEmpty());
const detail = new Detail();
const replay = new Replay(status);
const sensors = new Sensors(() => {
  status.condition.sensors = [...sensors.known.values()];
  map.invalidate();
});
const cluster = new Cluster();
const raw = (map.raw = new Raw(map));
const conflicts = (map.conflicts = new Conflicts(map));

// ── data from the service

const reads = new Reads(showKnown, () => status.utc());
const alerts = new Alerts({
  changed(byTrack, covered) {
    map.alerted = byTrack;
    conflicts.cover(covered);
    map.invalidate();
  },
  renewHistory: () => reads.renew("history"),
  go: (ids) => map.go(ids),
});
const activeZones = new ActiveZones(() => reads.renew("zones"), () => reads.renew("areas"));
const ground = new Ground(
  map,
  (picture) => {
    [map.picture, table.picture, detail.picture] = [picture, picture, picture];
  },
  (layer, isGood, why = "") => {
    map.invalidate();
    if (isGood) reads.good(layer);
    else reads.failed(layer, why);
  },
);

reads.add("tracks", "Tracks"); // updated by the stream
reads.add("info", "Service", { ask: () => get("info"), take: takeInfo, everyMs: RENEW_MS });
reads.add("state", "State of the service", { ask: askState, take: (answer) => status.takeState(answer), everyMs: STATE_MS });
reads.add("sensors", "Sensors", { ask: () => get("sensors"), take: takeSensors, everyMs: RENEW_MS });
reads.add("cluster", "Cluster", { ask: () => get("cluster"), take: takeCluster, everyMs: CLUSTER_MS, isWanted: () => status.info?.cluster === true });
reads.add("alerts", "Alerts", { ask: () => get("alerts"), take: (answer) => alerts.replace(answer), everyMs: RENEW_MS });
reads.add("history", "Alert history", { ask: () => alerts.history.ask(), take: (answer) => alerts.history.take(answer), everyMs: RENEW_MS, isWanted: () => alerts.history.isWanted });
reads.add("conflicts", "Conflicts", { ask: () => get("conflicts?level=advisory"), take: (answer) => conflicts.take(answer), everyMs: CONFLICTS_MS, isWanted: () => conflicts.isWanted && !past.isOn });
reads.add("integrity", "Integrity", { ask: () => get("integrity"), take: (answer) => detail.verdicts.replace(list(answer, "identities")) });
reads.add("coverage", "Coverage", { ask: () => get("coverage"), take: takeCoverage });
reads.add("areas", "Areas", { ask: () => get("areas"), take: takeAreas });
reads.add("zones", "Zones of operators", { ask: () => get("zones"), take: (answer) => activeZones.take(answer), everyMs: RENEW_MS });
reads.add("raw", "Raw inputs", { ask: () => raw.ask(), take: (answer) => raw.take(answer), everyMs: RAW_MS, isWanted: () => raw.isWanted });
reads.add("base", "Base map");
reads.add("tiles", "Map tiles");
reads.add("page", "This page");

/** Shows in each count and list whether it is known. */
function showKnown() {
  status.condition.isKnown = reads.state("state") === "good";
  showFailures(reads.failures());
  alerts.setRead(reads.of("alerts"));
  sensors.setRead(reads.of("sensors"));
  cluster.setRead(reads.of("cluster"));
  const { state, why } = reads.of("conflicts");
  if (state !== "good") conflicts.forget(why);
  table.refresh();
  frameOnce();
}

function isPictureKnown() {
  return reads.state("tracks") === "good" && !status.isStale && Number.isFinite(status.pictureTime);
}

/** State of the service, with the moments of the request and of the answer. */
async function askState() {
  const asked = performance.now();
  const answer = await get("status");
  return { answer, asked, received: performance.now() };
}

/** @param {Info} info */
function takeInfo(info) {
  if (typeof info?.profile !== "string") throw new Error("the answer has no profile");
  status.info = info;
  detail.info = info;
  cluster.offer(info.cluster === true);
  const site = info.site?.name ?? "";
  setText(byId("site"), site);
  alerts.site = site;
  alerts.setControl(info.control === true);
  activeZones.setControl(info.control === true);
  sensors.setControl(info.control === true);
  byId("site").title = `version ${info.version ?? "?"}, profile ${info.profile}`;
  if (Number.isFinite(info.latency_s) && !status.isNow) status.latency = info.latency_s;
  if (info.now !== true && settings.at !== "lagged") change({ at: "lagged" });
  ground.takeTiles(info);
  setText(byId("attribution"), [info.basemap?.attribution, info.tiles?.attribution].filter(Boolean).join("; "));
  noteBaseMap(Boolean(info.basemap ?? info.tiles));
  offerLayer("base", Boolean(info.basemap));
  offerLayer("tiles", Boolean(info.tiles));
  offerLayer("cells", cluster.outlines().features.length > 0);
  past.offer(info.history_hours);
  if (status.isReplay) replay.update(info.replay ?? {});
}

/** @param {SensorsAnswer} collection */
function takeSensors(collection) {
  ground.takeSensors(collection);
  sensors.replace(collection);
}

/** @param {Answer<"coverage">} coverage */
function takeCoverage(coverage) {
  ground.takeShapes("coverage", coverage);
  frameOnce();
}

/** @param {AreasAnswer} areas */
function takeAreas(areas) {
  ground.takeAreas(areas);
  takeZones(areas);
  renewWhenZonesChange(areas);
  frameOnce();
}

/** @type {number | undefined} */
let zonesTimer;

/** Takes the members of the cluster, and its cells for the map. @param {Members} answer */
function takeCluster(answer) {
  cluster.replace(answer);
  ground.takeShapes("cells", cluster.outlines());
  offerLayer("cells", cluster.outlines().features.length > 0);
}

/** Requests the zones again when one of them comes into force or ends. @param {AreasAnswer} areas */
function renewWhenZonesChange({ features }) {
  const times = features.map(({ properties }) => Date.parse(properties?.changes_at)).filter(Number.isFinite);
  const wait = Math.max(MIN_ZONES_MS, Math.min(...times) - status.utc());
  clearTimeout(zonesTimer);
  if (wait < MOST_ZONES_MS) zonesTimer = setTimeout(() => reads.renew("areas"), wait);
}

function frameOnce() {
  if (reads.state("sensors") !== "unknown" || performance.now() >= FRAME_MS) map.frameOnce();
}

/** @type {Track | null} */
let chosen = null; // last known state of the selected track

/** If the selected track has ended and its aircraft continues under another id, the selection follows. */
function keepSelection() {
  const track = map.picture?.tracks.get(settings.selected ?? "");
  if (track) {
    chosen = track;
  } else if (chosen) {
    const heir = map.picture?.heirOf(chosen);
    if (heir) change({ selected: heir.id });
  }
}

/** @param {TrackCollection} collection */
function took(collection) {
  status.took(collection);
  keepSelection();
  frameOnce();
  if (status.isReplay) replay.at(Date.parse(collection.time));
  map.invalidate();
}

/** Identities as known now, because the history has none. */
/** @type {Map<string, UasId | undefined>} */
let identities = new Map();

/** Shows a past picture instead of the stream. @param {TrackCollection} collection */
function showPast(collection) {
  const { picture } = map;
  if (!picture) return;
  if (!status.past) identities = new Map([...picture.tracks.values()].map(({ id, properties }) => [id, properties.uas_id]));
  for (const { properties } of list(collection, "features")) properties.uas_id = identities.get(properties.id);
  picture.snapshot(collection);
  status.past = Date.parse(collection.time);
  status.show();
  map.invalidate();
  table.refresh();
  detail.refresh();
}

function showLive() {
  status.past = null;
  map.picture?.forget();
  stream.reopen();
}

function start() {
  return new Stream(() => ({ at: settings.at, trailS: settings.trailS }), {
    // Changes missed meanwhile are in no event.
    opened: () => reads.renew("info", "state", "sensors", "alerts", "integrity", "coverage", "areas", "zones"),
    failed(wait, why) {
      status.failed(wait);
      reads.failed("tracks", why);
    },
    snapshot(collection) {
      if (past.isOn) return status.heard({});
      ground.takeTracks(collection);
      map.picture?.snapshot(collection);
      status.began();
      took(collection);
      reads.good("tracks");
      table.refresh();
    },
    tracks(collection) {
      if (past.isOn) return status.heard({});
      ground.takeTracks(collection);
      map.picture?.update(collection);
      took(collection);
      reads.good("tracks");
    },
    ended(event) {
      status.heard({});
      if (past.isOn) return;
      map.picture?.end(list(event, "ids"));
      keepSelection();
      map.invalidate();
    },
    sensor(properties) {
      status.heard({});
      sensors.update(properties);
      reads.renew("state");
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
    // A snapshot of the tracks follows, which includes missed changes.
    resync() {
      status.heard({});
      reads.renew("sensors", "alerts", "integrity");
    },
  });
}

const past = new Past(() => status.pictureTime, { show: showPast, live: showLive });
const operator = new Operator({ map, status, replay, alerts, activeZones, reads, isPictureKnown });

onChange((patch) => {
  if ("selected" in patch) {
    chosen = map.picture?.tracks.get(settings.selected ?? "") ?? null;
    detail.refresh();
  }
  if ("units" in patch || "groundM" in patch) ground.nameZones();
  if ("units" in patch || "groundM" in patch || "watched" in patch) detail.refresh();
});

operator.show();
welcome();
for (const kind of ["error", "unhandledrejection"]) {
  addEventListener(kind, () => reads.failed("page", "an error in it; load it anew"));
}
setTimeout(frameOnce, FRAME_MS);
reads.renew("info", "state", "sensors");
const stream = start();
// A browser may keep a page that was left with its connection, and has only six of them per service.
addEventListener("pagehide", () => stream.close());
addEventListener("pageshow", ({ persisted }) => persisted && stream.reopen());
onChange((patch) => {
  if ("at" in patch) stream.reopen();
  if ("trailS" in patch) {
    map.picture?.forget(); // otherwise the older part of a longer trail would stay unknown
    stream.reopen();
  }
});
