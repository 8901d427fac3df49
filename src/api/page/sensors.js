// The lights of the sensors: colour, shape and letter by state, the reasons on hover and on click.

import { byId, element, setAttribute, setText } from "./dom.js";
import * as format from "./format.js";

const STATES = {
  operational: ["ok", "●"],
  degraded: ["warning", "▲"],
  outage: ["critical", "■"],
};

const UNKNOWN = "?"; // the light of all that no configuration names

export class Sensors {
  known = new Map(); // properties by id
  unknown = [];
  opened = null;

  constructor(changed) {
    this.changed = changed;
    this.list = byId("sensors");
    this.panel = byId("sensor-panel");
    this.panel.addEventListener("toggle", (event) => {
      if (event.newState === "closed") this.opened = null;
    });
  }

  /** The answer of /sensors. */
  replace(collection) {
    this.known = new Map((collection.features ?? []).map(({ properties }) => [properties.id, properties]));
    this.unknown = collection.unknown ?? [];
    for (const item of [...this.list.children]) {
      const { id } = item.dataset;
      if (id === UNKNOWN ? !this.unknown.length : !this.known.has(id)) item.remove();
    }
    this.show();
  }

  /** One sensor's news; what it does not say stays as it was. */
  update(properties) {
    this.known.set(properties.id, { ...this.known.get(properties.id), ...properties });
    this.show();
  }

  show() {
    for (const sensor of this.known.values()) this.light(sensor.id, sensor.id, sensor.state, summary(sensor));
    if (this.unknown.length) {
      this.light(UNKNOWN, `${this.unknown.length} unknown`, "degraded", "Heard, but in no configuration: click to see which");
    }
    if (this.opened) this.fillPanel();
    this.changed();
  }

  light(id, name, state, title) {
    const [look, shape] = STATES[state] ?? ["unknown", "?"];
    let item = [...this.list.children].find((child) => child.dataset.id === id);
    if (!item) {
      const button = element("button", { type: "button", popovertarget: "sensor-panel" }, element("span", { class: "lamp" }), element("span"));
      button.addEventListener("click", () => {
        this.opened = id;
        this.fillPanel();
      });
      item = element("li", { "data-id": id }, button);
      this.list.append(item);
    }
    const button = item.firstChild;
    setAttribute(item, "data-look", look);
    setAttribute(button, "title", title);
    setAttribute(button, "aria-label", `Sensor ${name}: ${state}`);
    setText(button.firstChild, shape);
    setText(button.lastChild, name);
  }

  fillPanel() {
    const sensor = this.known.get(this.opened);
    const rows = sensor ? details(sensor) : this.unknown.map((source) => [unknownName(source), unknownText(source)]);
    const list = element("dl");
    for (const [term, text] of rows) list.append(element("dt", {}, term), element("dd", {}, text));
    const registered = sensor?.registration ? registration(sensor.registration) : [];
    this.panel.replaceChildren(element("h2", {}, sensor ? sensor.id : "Heard, but not configured"), list, ...registered);
  }
}

const reasons = ({ reasons }) => (reasons ?? []).map((reason) => (typeof reason === "string" ? reason : (reason.text ?? JSON.stringify(reason))));
const summary = (sensor) => [`${sensor.id}: ${sensor.state}`, ...reasons(sensor)].join("\n");

function details(sensor) {
  const rows = [
    ["Kind", sensor.kind],
    ["State", sensor.state],
  ];
  for (const reason of reasons(sensor)) rows.push(["Because", reason]);
  if (sensor.last_seen) rows.push(["Last seen", `${format.utc(Date.parse(sensor.last_seen), 1)} UTC`]);
  if (Number.isFinite(sensor.rate_hz)) rows.push(["Rate", `${sensor.rate_hz.toFixed(1)} a second`]);
  if (Number.isFinite(sensor.clock_offset_s)) rows.push(["Clock offset", format.seconds(sensor.clock_offset_s, 2)]);
  const said = ["id", "kind", "state", "reasons", "last_seen", "rate_hz", "clock_offset_s", "registration"];
  for (const [name, value] of Object.entries(sensor)) {
    if (said.includes(name) || value == null) continue;
    rows.push([name.replaceAll("_", " "), typeof value === "object" ? flat(value) : brief(value)]);
  }
  return rows;
}

const REGISTERED = [
  ["bearing_deg", "Bearing", "°", 2],
  ["tilt_east_deg", "Tilt about east", "°", 2],
  ["tilt_north_deg", "Tilt about north", "°", 2],
  ["range_m", "Range", " m", 1],
  ["height_m", "Height", " m", 1],
  ["time_s", "Time", " s", 2],
];
const MODES = {
  off: "off: nothing is estimated",
  propose: "propose: shown, plots stay as they are",
  apply: "apply: plots are put right by what is observable",
};

/** How a radar is set up wrongly, measured minus true; what is not observable is grey and in brackets. */
function registration(told) {
  const list = element("dl", { class: "registration" }, element("dt", {}, "Mode"), element("dd", {}, MODES[told.mode] ?? told.mode));
  for (const [key, name, unit, digits] of REGISTERED) {
    const value = told[key];
    if (!value) continue;
    const text = `${value.value < 0 ? "−" : "+"}${Math.abs(value.value).toFixed(digits)} ± ${value.deviation.toFixed(digits)}${unit}`;
    const known = value.observable ? {} : { class: "unknown", title: "Not observable: shown, and not applied" };
    list.append(element("dt", known, name), element("dd", known, value.observable ? text : `(${text})`));
  }
  const rest = [
    ["Radar tracks", told.tracks?.toFixed(1)],
    ["Residual", told.residual?.toFixed(2)],
    ["Latest step", told.step && `${format.utc(Date.parse(told.step.time))} UTC`],
  ];
  for (const [name, text] of rest) if (text) list.append(element("dt", {}, name), element("dd", {}, text));
  const parts = [element("h3", {}, "Registration"), list];
  if (told.alarm) parts.push(element("p", { class: "alarm" }, told.alarm));
  if (told.hint) parts.push(element("p", { class: "hint" }, told.hint));
  return parts;
}

const flat = (value) =>
  Object.entries(value).map(([name, inner]) => `${name.replaceAll("_", " ")} ${brief(inner)}`).join(", ") || "none";

const brief = (value) => {
  if (typeof value === "string" && /^\d{4}-\d\d-\d\dT/.test(value)) return `${format.utc(Date.parse(value))} UTC`;
  return typeof value === "object" ? JSON.stringify(value) : String(value);
};

const unknownName = ({ sac, sic, id }) => (sac != null ? `SAC ${sac} SIC ${sic}` : String(id ?? "?"));
const unknownText = ({ sac, sic, id, ...rest }) => flat(rest);
