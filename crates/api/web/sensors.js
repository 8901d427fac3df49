// Lights of the sensors: colour, shape and letter by state, with the reasons on hover and on click.

import { list, post } from "./api.js";
import { byId, element, setAttribute, setText } from "./dom.js";
import * as format from "./format.js";
import { LineRates } from "./lines.js";

/** @type {Record<string, [string, string] | undefined>} */
const STATES = {
  operational: ["ok", "●"],
  degraded: ["warning", "▲"],
  outage: ["critical", "■"],
};

const UNKNOWN = "?"; // light of all sources that are not configured
const ALL = "*"; // single light while no sensor is known

/** Elements of a light. @typedef {{ item: HTMLElement, button: HTMLElement, lamp: HTMLElement, words: HTMLElement }} Light */

export class Sensors {
  /** @type {Map<string, SensorProperties>} */
  known = new Map(); // by id
  /** @type {UnknownSource[]} */
  unknown = [];
  opened = ""; // id of the light whose panel is open
  /** @type {Read | null} */
  read = null; // of /sensors
  /** @type {Map<string, Light>} */
  lights = new Map(); // by id
  /** @type {Set<string>} */
  confirmed = new Set(); // ids of sensors with news since a failure
  lines = new LineRates();
  isControl = false; // whether the user may move radars
  failed = ""; // why the latest order was refused

  /** @param {() => void} changed */
  constructor(changed) {
    this.changed = changed;
    this.list = byId("sensors");
    this.panel = byId("sensor-panel");
    this.panel.addEventListener("toggle", (event) => {
      if (event.newState === "closed") this.opened = "";
      this.failed = "";
    });
    // One button for all radars: it keeps its focus while the panel is filled again.
    this.order = element("button", { type: "button", class: "decide" });
    this.order.addEventListener("click", () => this.relocate());
  }

  /** @param {boolean} isControl */
  setControl(isControl) {
    this.isControl = isControl;
    if (this.opened) this.fillPanel();
  }

  /** Moves the radar of the panel to where its tracks show it, or puts it back. */
  async relocate() {
    const id = this.opened;
    const told = this.known.get(id)?.registration;
    const path = /** @type {`relocations/${string}`} */ (`relocations/${encodeURIComponent(id)}`);
    try {
      await post(told?.place?.contradicts ? path : `${path}/revoke`);
      this.failed = "";
    } catch (error) {
      this.failed = String(error instanceof Error ? error.message : error);
    }
    this.fillPanel();
  }

  /** Takes the answer of /sensors. @param {SensorsAnswer} collection */
  replace(collection) {
    this.known = new Map(list(collection, "features").map(({ properties }) => [properties.id, properties]));
    this.unknown = collection.unknown ?? [];
    this.lines.note(Date.parse(collection.time), this.known.values());
    this.show();
  }

  /** Takes news of one sensor; properties missing in it stay. @param {SensorProperties} properties */
  update(properties) {
    this.known.set(properties.id, { ...this.known.get(properties.id), ...properties });
    this.confirmed.add(properties.id);
    this.show();
  }

  /** Whether the answer of /sensors is known. @param {Read} read */
  setRead(read) {
    if (read.state === "failed" && this.read?.state !== "failed") this.confirmed.clear();
    this.read = { ...read };
    this.show();
  }

  /** @param {string} id */
  isConfirmed(id) {
    return this.read?.state !== "failed" || this.confirmed.has(id);
  }

  show() {
    /** @type {Map<string, [string, string, string]>} */
    const lights = new Map();
    for (const sensor of this.known.values()) {
      const last = summary(sensor);
      const isConfirmed = this.isConfirmed(sensor.id);
      const state = (isConfirmed ? sensor.state : null) ?? "not known";
      lights.set(sensor.id, [sensor.id, state, isConfirmed ? last : `${this.doubt()}\nBefore:\n${last}`]);
    }
    if (!this.known.size && this.read?.state === "failed") lights.set(ALL, ["Sensors", "not known", this.doubt()]);
    if (this.unknown.length) {
      lights.set(UNKNOWN, [`${this.unknown.length} unknown`, "degraded", "Heard, but in no configuration: click to see which"]);
    }
    for (const [id, { item }] of this.lights) {
      if (lights.has(id)) continue;
      item.remove();
      this.lights.delete(id);
    }
    for (const [id, [name, state, title]] of lights) this.light(id, name, state, title);
    if (this.opened) this.fillPanel();
    this.changed();
  }

  doubt() {
    return `Not known since ${format.utc(this.read?.since ?? NaN)} UTC (${this.read?.why})`;
  }

  /** @param {string} id @param {string} name @param {string} state @param {string} title */
  light(id, name, state, title) {
    const [look, shape] = STATES[state] ?? ["unknown", "?"];
    const { item, button, lamp, words } = this.lights.get(id) ?? this.makeLight(id);
    setAttribute(item, "data-look", look);
    setAttribute(button, "title", title);
    setAttribute(button, "aria-label", id === ALL ? "Sensors: not known" : `Sensor ${name}: ${state}`);
    setText(lamp, shape);
    setText(words, name);
  }

  /** @param {string} id @returns {Light} */
  makeLight(id) {
    const [lamp, words] = [element("span", { class: "lamp" }), element("span")];
    const button = element("button", { type: "button", popovertarget: "sensor-panel" }, lamp, words);
    button.addEventListener("click", () => {
      this.opened = id;
      this.fillPanel();
    });
    const light = { item: element("li", { "data-id": id }, button), button, lamp, words };
    this.list.append(light.item);
    this.lights.set(id, light);
    return light;
  }

  fillPanel() {
    const sensor = this.known.get(this.opened);
    const parts = sensor ? this.describe(sensor) : this.describeRest();
    const hadFocus = document.activeElement === this.order;
    this.panel.replaceChildren(...parts.filter((part) => part !== null));
    if (hadFocus && this.panel.contains(this.order)) this.order.focus();
  }

  /** @param {SensorProperties} sensor */
  describe(sensor) {
    const doubt = this.isConfirmed(sensor.id) ? null : element("p", { class: "alarm" }, `${this.doubt()}; this is how it was then`);
    return [
      element("h2", {}, sensor.id),
      doubt,
      terms(details(sensor)),
      ...(sensor.lines?.length ? [element("h3", {}, "Lines"), this.lines.table(sensor)] : []),
      ...(sensor.registration ? registration(sensor.registration) : []),
      ...this.describeOrder(sensor),
      ...(sensor.orientation ? orientation(sensor.orientation) : []),
      ...(sensor.learnt ? learnt(sensor.learnt) : []),
      ...(sensor.transponder_types ? learntTypes(sensor.transponder_types) : []),
    ];
  }

  /** The button that moves a radar or puts it back, if there is anything to do. @param {SensorProperties} sensor */
  describeOrder(sensor) {
    const { place, relocated } = sensor.registration ?? {};
    const failed = this.failed ? [element("p", { class: "alarm" }, this.failed)] : [];
    if (!this.isControl || !(place?.contradicts || relocated)) return failed;
    setText(this.order, place?.contradicts ? "Apply this position" : "Use the configured position again");
    return [this.order, ...failed];
  }

  describeRest() {
    if (this.opened === ALL) return [element("h2", {}, "Sensors"), element("p", { class: "alarm" }, this.read?.why ? this.doubt() : "Known again")];
    return [element("h2", {}, "Heard, but not configured"), terms(this.unknown.map((source) => [unknownName(source), unknownText(source)]))];
  }
}

/** @param {[string, string][]} rows */
function terms(rows) {
  const list = element("dl");
  for (const [term, text] of rows) list.append(element("dt", {}, term), element("dd", {}, text));
  return list;
}

/** @param {SensorProperties} sensor */
const reasons = ({ reasons }) => (reasons ?? []).map((reason) => (typeof reason === "string" ? reason : format.words(reason)));
/** @param {SensorProperties} sensor */
const summary = (sensor) => [`${sensor.id}: ${sensor.state ?? "not known"}`, ...reasons(sensor)].join("\n");

const SAID = ["id", "kind", "sac", "sic", "state", "reasons", "last_seen", "rate_hz", "clock_offset_s", "registration", "orientation", "learnt", "transponder_types", "lines"];

/** @param {SensorProperties} sensor */
function details(sensor) {
  /** @type {[string, string][]} */
  const rows = [["Kind", sensor.kind]];
  if (sensor.sac !== undefined) rows.push(["SAC, SIC", `${sensor.sac}, ${sensor.sic}`]);
  rows.push(["State", sensor.state ?? "not known"]);
  for (const reason of reasons(sensor)) rows.push(["Because", reason]);
  if (sensor.last_seen) rows.push(["Last seen", `${format.utc(Date.parse(sensor.last_seen), 1)} UTC`]);
  if (Number.isFinite(sensor.rate_hz)) rows.push(["Rate", `${sensor.rate_hz.toFixed(1)} a second`]);
  if (Number.isFinite(sensor.clock_offset_s)) rows.push(["Clock offset", format.seconds(sensor.clock_offset_s, 2)]);
  for (const [name, value] of Object.entries(sensor)) {
    if (!SAID.includes(name) && value != null) rows.push([format.heading(name), format.words(value)]);
  }
  return rows;
}

const REGISTERED = /** @type {const} */ ([
  ["bearing_deg", "Bearing", "°", 2],
  ["tilt_east_deg", "Tilt about east", "°", 2],
  ["tilt_north_deg", "Tilt about north", "°", 2],
  ["range_m", "Range", " m", 1],
  ["height_m", "Height", " m", 1],
  ["time_s", "Time", " s", 2],
]);
const MODES = {
  off: "off: nothing is estimated",
  propose: "propose: shown, plots stay as they are",
  apply: "apply: plots are corrected by what is observable",
};

/** Misalignment of a radar, measured minus true. Unobservable values are grey and in brackets. @param {Registration} told */
function registration(told) {
  const list = element("dl", { class: "registration" }, element("dt", {}, "Mode"), element("dd", {}, MODES[told.mode] ?? told.mode));
  for (const [key, name, unit, digits] of REGISTERED) {
    const value = told[key];
    if (value) list.append(...bias(value, name, unit, digits));
  }
  const rest = [
    ["Radar tracks", told.tracks?.toFixed(1)],
    ["Residual", told.residual?.toFixed(2)],
    ["Latest step", told.step && `${format.utc(Date.parse(told.step.time))} UTC`],
    ["Stands, by its tracks", told.place && placeText(told.place)],
    ["Moved by an operator", told.relocated && away(told.relocated)],
  ];
  for (const [name, text] of rest) if (text) list.append(element("dt", {}, name), element("dd", {}, text));
  const parts = [element("h3", {}, "Registration"), list];
  if (told.alarm) parts.push(element("p", { class: "alarm" }, told.alarm));
  if (told.hint) parts.push(element("p", { class: "hint" }, told.hint));
  return parts;
}

/** @param {NonNullable<Registration["place"]>} place */
function placeText(place) {
  const sigma = Math.max(place.east_sigma_m, place.north_sigma_m).toFixed(0);
  return `${away(place)} ± ${sigma} m${place.contradicts ? ": contradicts its position" : ""}`;
}

/** @param {{ east_m: number, north_m: number }} by */
function away({ east_m: east, north_m: north }) {
  return `${Math.abs(east).toFixed(0)} m ${east < 0 ? "west" : "east"}, ${Math.abs(north).toFixed(0)} m ${north < 0 ? "south" : "north"}`;
}

/** A bias with its deviation. @param {Bias} value @param {string} name @param {string} unit @param {number} digits */
function bias(value, name, unit, digits) {
  const text = `${value.value < 0 ? "−" : "+"}${Math.abs(value.value).toFixed(digits)} ± ${value.deviation.toFixed(digits)}${unit}`;
  const known = value.observable ? {} : { class: "unknown", title: "Not observable: shown, and not applied" };
  return [element("dt", known, name), element("dd", known, value.observable ? text : `(${text})`)];
}

/** Orientation of a camera, measured minus true. @param {CameraOrientation} told */
function orientation(told) {
  const list = element("dl", { class: "registration" });
  for (const [key, name, unit, digits] of REGISTERED.slice(0, 3)) {
    list.append(...bias(told[/** @type {"bearing_deg" | "tilt_east_deg" | "tilt_north_deg"} */ (key)], name, unit, digits));
  }
  const rest = [
    ["Looks", String(told.looks)],
    ["Residual", told.residual_deg === undefined ? "" : `${told.residual_deg.toFixed(2)}°`],
    ["Turned", told.turned && `${format.utc(Date.parse(told.turned))} UTC`],
  ];
  for (const [name, text] of rest) if (text) list.append(element("dt", {}, name), element("dd", {}, text));
  return [element("h3", {}, "Orientation, as learnt"), list];
}

const LEARNT = /** @type {const} */ ([
  ["range_m", "Range", " m", 1],
  ["azimuth_deg", "Azimuth", "°", 2],
  ["height_m", "Height", " m", 1],
]);
const VELOCITIES = { unknown: "not known yet, so not used", used: "used", ignored: "ignored" };

/** Learnt errors of a radar, compared with its data sheet. @param {Learnt} told */
function learnt(told) {
  const list = element("dl", { class: "registration" });
  for (const [key, name, unit, digits] of LEARNT) {
    const { of_data_sheet: share, bias, noise } = told[key];
    const text = `${share.value.toFixed(1)} of its data sheet ± ${share.deviation.toFixed(1)}`;
    const title = `Bias ${bias.value.toFixed(digits)}${unit}, noise ${noise.value.toFixed(digits)}${unit}`;
    list.append(element("dt", { title }, name), element("dd", { title }, text));
  }
  const { verdict, error_m_s: off } = told.velocity;
  const text = (VELOCITIES[verdict] ?? verdict) + (off ? `: ${off.value.toFixed(1)} m/s off` : "");
  list.append(element("dt", {}, "Velocities"), element("dd", {}, text));
  list.append(element("dt", {}, "Samples"), element("dd", {}, told.azimuth_deg.samples.toFixed(0)));
  return [element("h3", {}, "Errors, as learnt"), list];
}

/** Common errors of transponders of one make and model. @param {LearntTransponderType[]} types */
function learntTypes(types) {
  const list = element("dl", { class: "registration" });
  for (const { manufacturer, model, summary, reports, horizontal_m: noise, delay_s: delay } of types) {
    const text = `noise ${noise.value.toFixed(2)} m, delay ${delay.value.toFixed(2)} ± ${delay.deviation.toFixed(2)} s, ${delay.applied.toFixed(2)} s applied; ${reports} reports`;
    list.append(element("dt", { title: summary }, [manufacturer ?? "?", model ?? "?"].join(" ")), element("dd", { title: summary }, text));
  }
  return [element("h3", {}, "Transponders, as learnt"), list];
}

/** @param {UnknownSource} source */
const unknownName = ({ sac, sic }) => `SAC ${sac} SIC ${sic}`;
/** @param {UnknownSource} source */
const unknownText = ({ sac, sic, ...rest }) => format.words(rest);
