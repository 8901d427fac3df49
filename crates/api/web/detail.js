// Details of the selected track, and the reasons why it is fused or not.

import { get, list, post } from "./api.js";
import { byId, element } from "./dom.js";
import * as format from "./format.js";
import { idOf, nameOf, shortName } from "./names.js";
import { change, settings, toggled } from "./settings.js";
import { say, trustProperties, Verdicts } from "./trust.js";
import * as units from "./units.js";

/** @type {Record<string, string | undefined>} */
const TYPE_WORDS = { crewed: "an aircraft with somebody on board", vehicle: "a vehicle on the ground" };

const SOURCE_WORDS = {
  fused: "radar and transponder, fused",
  radar: "radar only",
  transponder: "transponder only",
  camera: "cameras only",
};
/** @type {Record<string, string | undefined>} */
const STATE_WORDS = {
  coasting: "coasting: extrapolated from the last measurement",
};
/** A radar track and a transponder. @typedef {{ sensor: string, track: number, uas: string, country?: string }} Pair */
/** @typedef {"correlated" | "decorrelated" | "automatic"} Decision */
/** @typedef {(about: Pair, decision: Decision) => void} Decide */

const EVERY_MS = 500;
const ASK_MS = 1000;

/** @param {boolean | undefined} value */
const yes = (value) => (value == null ? null : value ? "yes" : "no");
/**
 * The text of a value; null if it is unknown.
 * @template T @param {T | null | undefined} value @param {(value: T) => string} text
 */
const known = (value, text) => (value == null || Number.isNaN(value) ? null : text(value));

/** @param {number} ms */
const preciseTime = (ms) => `${format.utc(ms, 2)} UTC`;

/**
 * Confidence that two tracks are one aircraft, from the natural logarithm of the likelihood ratio: 20 to 1, and 3 to 1.
 * @param {number} value
 */
const confidence = (value) => (value >= Math.log(20) ? "high" : value >= Math.log(3) ? "medium" : "low");

/** Bound of 95 % of the errors, and its class in ASTM F3411. @param {number} value @param {string | undefined} name */
const accuracy = (value, name) => `${format.metres(value, 1)} (95${format.THIN}%)${name ? `, ${name}` : ""}`;

/** The known properties of a track. @param {Track} track @param {number} time @returns {Property[]} */
function properties(track, time) {
  const p = track.properties;
  const uas = p.uas_id ?? {};
  const derived = track.derived ? " (derived from the last 5 s of positions)" : "";
  /** @param {string} text */
  const radar = (text) => `${text} (radar)`;
  /** @type {Property[]} */
  const all = [
    ["Callsign", p.aircraft?.callsign],
    ["Serial number", uas.serial_number],
    ["Registration", uas.registration_id],
    ["Flight identity", uas.utm_id],
    ["Session identity", uas.specific_session_id],
    ["ICAO address", p.aircraft?.icao24],
    ["Also", (p.also ?? []).map((other) => idOf(other.uas_id) || other.aircraft?.icao24).filter(Boolean).join(", ")],
    [units.heightName(), known(p.alt_msl, (value) => units.height(value, 1)) ?? "not measured"],
    ["Vertical speed", known(p.vertical_speed, units.climb)],
    ["Speed", known(track.speed, (value) => `${units.speed(value, 1)}${derived}`)],
    ["Course", known(track.course, (value) => `${format.direction(value)}${derived}`)],
    ...trustProperties(track),
    ["Source", SOURCE_WORDS[track.source] ?? track.source],
    ["State", STATE_WORDS[p.state ?? ""] ?? p.state],
    ["Drone", known(p.uav_probability, (value) => radar(`${format.percent(value)} likely`))],
    ["Type", TYPE_WORDS[p.aircraft_type ?? ""]],
    ["Position", format.position(p.lat, p.lng)],
    ["From the radar", known(track.range, (value) => `${units.distance(value)} at ${track.bearing.toFixed(1)}°`)],
    ["Accuracy, horizontal", known(p.accuracy_h_m, (value) => accuracy(value, p.accuracy_h)) ?? p.accuracy_h],
    ["Accuracy, vertical", known(p.accuracy_v_m, (value) => accuracy(value, p.accuracy_v)) ?? p.accuracy_v],
    ["Emitter category", p.aircraft?.emitter_category],
    ["Declared type", p.remote_id?.ua_type],
    ["Declared status", p.remote_id?.operational_status],
    [
      p.remote_id?.height?.reference === "GroundLevel" ? "Declared height, ground" : "Declared height, take-off",
      known(p.remote_id?.height?.distance, (value) => units.height(value, 1)),
    ],
    ["Operator", p.remote_id?.operator_id],
    ["Operator's position", known(p.remote_id?.operator_location, (place) => format.position(place.lat, place.lng))],
    ["Manufacturer", uas.manufacturer],
    ["Model", uas.model],
    ["Registered in", uas.registration_country],
    ["Interpolated", yes(p.interpolated)],
    ["Extrapolated", p.extrapolated ? "yes" : null],
    ["Time of position", preciseTime(track.time)],
    ["Last measurement", known(p.last_measurement, (value) => preciseTime(Date.parse(value)))],
    ["Age", known(p.age_s ?? (time - track.time) / 1000, (value) => format.seconds(value, 2))],
    ["First seen", known(p.first_seen, (value) => `${format.date(Date.parse(value))} ${format.utc(Date.parse(value))} UTC, ${format.duration((time - Date.parse(value)) / 1000)} ago`)],
    ["Height, ellipsoid", known(p.alt, (value) => format.metres(value, 1))],
    ["Geoid separation", known(p.geoid_separation, (value) => format.metres(value, 1))],
    ["Track number", track.name],
    ["Id", track.id],
  ];
  return all.filter(([, text]) => text != null && text !== "");
}

/**
 * Reason of an association: "radar track 134: 88.3 m of 152.4 m allowed, within in 72 of 72 slots (needs 90 %)", or a likelihood
 * ratio and the threshold below which the pair is separated.
 * @param {Contributor} contributor @param {number | undefined} needed
 */
function reason(contributor, needed) {
  const { kind, track_number, distance_m, threshold_m, within, co_present, ratio, log_likelihood_ratio, threshold, manual } = contributor;
  const parts = [];
  if (Number.isFinite(distance_m)) {
    parts.push(`${distance_m.toFixed(1)} m` + (Number.isFinite(threshold_m) ? ` of ${threshold_m.toFixed(1)} m allowed` : " apart"));
  }
  if (Number.isFinite(within) && Number.isFinite(co_present)) {
    const needs = Number.isFinite(needed) ? ` (needs ${format.percent(needed)})` : "";
    parts.push(`within in ${within} of ${co_present} slots${needs}`);
  } else if (Number.isFinite(ratio)) {
    parts.push(`within in ${format.percent(ratio)} of the slots`);
  }
  if (Number.isFinite(log_likelihood_ratio)) {
    parts.push(`${confidence(log_likelihood_ratio)} confidence`);
  }
  if (manual) parts.push("an operator has said so");
  const own = `${kind} track ${track_number}`;
  const limit = manual || !threshold ? "" : `; separated below ${threshold.part}`;
  const title = Number.isFinite(log_likelihood_ratio) ? `Log-likelihood ratio ${log_likelihood_ratio.toFixed(1)}${limit}` : null;
  return { ...contributor, own, why: parts.join(", "), title };
}

/**
 * Radar track and transponder of a decision: a part of this track, with the rest of it or with a competitor.
 * @param {Track} track @param {Contributor} part @param {Competitor} [competitor]
 */
function pair(track, part, competitor) {
  const radar = part.kind === "radar" ? part : competitor;
  const uas = competitor?.uas_id ?? track.properties.uas_id;
  if (radar?.track_number === undefined || !uas) return null;
  return { sensor: radar.sensor, track: radar.track_number, ...identity(uas) };
}

/** A transponder in the parameters of a decision. @param {UasId} uas */
const identity = (uas) => ({ uas: idOf(uas), ...(uas.registration_country ? { country: uas.registration_country } : {}) });

/**
 * A button for a decision. Its id stays the same at a refresh.
 * @param {string} words @param {Pair} about @param {Decision} verdict @param {Decide} decide
 */
function button(words, about, verdict, decide) {
  const id = `decide-${verdict}-${about.sensor}-${about.track}-${about.uas}`;
  const made = element("button", { type: "button", id, class: "decide" }, words);
  made.addEventListener("click", () => decide(about, verdict));
  return made;
}

/**
 * Competing associations of a part of the track, with buttons for decisions; `decide` is null if the user may not decide.
 * @param {Track} track @param {Contributor} part @param {Decide | null} decide
 */
function competitors(track, part, decide) {
  return (part.competitors ?? []).map((competitor) => {
    const { sensor, track_number, uas_id, log_likelihood_ratio, decorrelated } = competitor;
    const who = uas_id ? `transponder ${idOf(uas_id)}` : `radar track ${track_number} of ${sensor}`;
    const line = element("small", { class: "competitor", title: `Log-likelihood ratio ${log_likelihood_ratio.toFixed(1)}` }, `near: ${who}, ${confidence(log_likelihood_ratio)} confidence `);
    const about = pair(track, part, competitor);
    if (decide && about && !decorrelated) line.append(button(`One aircraft with ${who}`, about, "correlated", decide));
    return line;
  });
}

/**
 * `whole` is the track as requested separately, because the stream leaves competitors out.
 * @param {Track} track @param {TrackFeature | null} whole @param {Info | null} info @param {Decide | null} decide
 */
function contributors(track, whole, info, decide) {
  const needed = info?.settings?.ratio_min;
  const list = element("ul", { class: "contributors" });
  for (const contributor of track.properties.contributors ?? []) {
    const { own, sensor, weight, why, title, kind, time, height_measured, ratio } = reason(contributor, needed);
    const item = element("li", { "data-kind": kind, title }, element("strong", {}, `${own}${why ? ": " : ""}`), why);
    if (Number.isFinite(ratio)) {
      // A bar shows how near the pair is to the limit.
      const meter = element("meter", { min: 0, max: 1, value: ratio, "aria-label": "Share of the slots within the limit" });
      if (Number.isFinite(needed)) [meter.low, meter.high, meter.optimum] = [needed, needed, 1];
      item.append(meter);
    }
    const small = [
      sensor,
      known(weight, (value) => `weight ${format.percent(value)}`),
      known(time, (value) => `measured ${format.utc(Date.parse(value), 2)}`),
      height_measured === false ? "no height of its own" : null,
    ];
    item.append(element("small", {}, small.filter(Boolean).join(" · ")));
    const about = track.source === "fused" && kind === "radar" ? pair(track, contributor) : null;
    if (decide && about) item.append(button("Not one aircraft", about, "decorrelated", decide));
    /** @param {Contributor} part */
    const isIt = (part) => part.kind === kind && part.sensor === sensor && part.track_number === contributor.track_number;
    item.append(...competitors(track, whole?.properties.contributors?.find(isIt) ?? contributor, decide));
    list.append(item);
  }
  return list;
}

/**
 * The decisions in force about a part of the track. They are shown when the two are far apart too, so that they can be withdrawn.
 * @param {Track} track @param {Correlation[]} decisions @param {Decide | null} decide
 */
function decided(track, decisions, decide) {
  const own = idOf(track.properties.uas_id ?? {});
  /** @param {Correlation} decision */
  const isAbout = ({ sensor, track_number, uas_id }) =>
    idOf(uas_id) === own ||
    (track.properties.contributors ?? []).some((part) => part.kind === "radar" && part.sensor === sensor && part.track_number === track_number);
  return decisions.filter(isAbout).map(({ sensor, track_number, uas_id, verdict }) => {
    const about = { sensor, track: track_number, ...identity(uas_id) };
    const words = `An operator: radar track ${track_number} of ${sensor} and transponder ${idOf(uas_id)} are ${verdict === "correlated" ? "" : "not "}one aircraft. `;
    return element("p", { class: "decision" }, words, decide ? button("Decide automatically", about, "automatic", decide) : "");
  });
}

/** @param {Track} track */
function watchButton({ watchId }) {
  const isWatched = settings.watched.has(watchId);
  const made = element("button", { type: "button", id: "watch", "aria-pressed": String(isWatched), title: "Watch list (w)" }, isWatched ? "★ Watched" : "☆ Watch");
  made.addEventListener("click", () => change({ watched: toggled(settings.watched, watchId) }));
  return made;
}

const WHY = {
  fused: "Why it is fused",
  radar: "Not fused: no transponder has kept close enough to it",
  transponder: "Not fused: no radar track has kept close enough to it",
  camera: "The lines of sight of these cameras cross here",
};
const WHY_OPERATIONAL = {
  fused: WHY.fused,
  radar: "Not fused: no transponder is likely to be it",
  transponder: "Not fused: no radar track is likely to be it now",
  camera: WHY.camera,
};

export class Detail {
  /** @type {Picture | null} */
  picture = null;
  /** @type {Info | null} */
  info = null;
  /** @type {Track | null} */
  last = null; // last state of the track, shown after it ends
  /** @type {TrackFeature | null} */
  whole = null; // selected track with its competitors
  /** @type {Correlation[]} */
  decisions = []; // in force, of operators
  asked = { id: "", next: 0 }; // id of the requested track, and time of the next request
  verdicts = new Verdicts();
  /** @type {{ id: string | null, text: string } | null} */
  said = null; // answer to the last decision, and the id of its track

  constructor() {
    this.node = byId("detail");
    setInterval(() => {
      this.ask();
      this.refresh();
    }, EVERY_MS);
  }

  refresh() {
    const { selected } = settings;
    this.node.hidden = !selected;
    if (!selected) {
      this.last = null;
      return;
    }
    const track = this.picture?.tracks.get(selected);
    const isGone = !track;
    if (track) this.last = track;
    else if (this.last?.id !== selected) this.last = null;
    // A text selection for copying is lost at a refresh, so the panel is not refreshed meanwhile.
    const marked = getSelection();
    if (marked && !marked.isCollapsed && this.node.contains(marked.anchorNode)) return;
    if (this.node.querySelector("button:active")) return; // nor while a button is pressed
    const focused = this.node.contains(document.activeElement) ? document.activeElement?.id : "";
    const { scrollTop } = this.node;
    this.node.replaceChildren(...this.content(selected, isGone));
    this.node.scrollTop = scrollTop;
    if (focused) document.getElementById(focused)?.focus();
  }

  /** Requests the competitors and the decisions once a second, and at once for another track. */
  async ask() {
    const { selected } = settings;
    if (!selected || this.info?.profile !== "operational") return;
    if (this.asked.id === selected && performance.now() < this.asked.next) return;
    this.asked = { id: selected, next: Infinity }; // no further request while one is pending
    try {
      this.decisions = list(await get("correlations"), "correlations");
      this.whole = await get(`tracks/${encodeURIComponent(selected)}`);
    } catch {
      this.whole = null; // the track has ended or the service is unreachable, which the page shows elsewhere
    }
    if (this.asked.id === selected) this.asked.next = performance.now() + ASK_MS;
  }

  /** Records a decision on a radar track and a transponder, if the user may. @param {Pair} about @param {Decision} verdict */
  async decide(about, verdict) {
    const id = settings.selected;
    try {
      this.decisions = list(await post("correlations", { ...about, verdict }), "correlations");
      this.said = { id, text: "Decided; it shows with the next slots." };
    } catch (error) {
      this.said = { id, text: error.message };
    }
    this.refresh();
  }

  /** Records a verdict on a transponder, if the user may. @param {UasId} transponder @param {Verdict} verdict */
  async judge(transponder, verdict) {
    const id = settings.selected;
    try {
      this.verdicts.replace(list(await say(transponder, verdict), "identities"));
      this.said = { id, text: "Decided; it shows with the next slots." };
    } catch (error) {
      this.said = { id, text: error.message };
    }
    this.refresh();
  }

  /** @param {string} selected @param {boolean} isGone */
  content(selected, isGone) {
    const track = this.last;
    const close = element("button", { type: "button", id: "detail-close", "aria-label": "Close the details", title: "Close (Esc)" }, "×");
    close.addEventListener("click", () => change({ selected: null, follow: false }));
    const name = track ? shortName(track) : nameOf(selected);
    const heading = element("h2", { "data-source": track?.source }, name, element("span", {}, track ? watchButton(track) : null, " ", close));
    if (!track) return [heading, element("p", { class: "empty" }, "Not in the picture (any more)")];
    const why = this.info?.profile === "operational" ? WHY_OPERATIONAL : WHY;
    const mayDecide = !isGone && this.info?.profile === "operational" && this.info.control;
    /** @type {Decide | null} */
    const decide = mayDecide ? (about, verdict) => this.decide(about, verdict) : null;
    const entries = element("dl");
    for (const [term, text, title] of properties(track, this.picture?.time ?? NaN)) {
      entries.append(element("dt", { title }, term), element("dd", { title }, String(text)));
    }
    return [
      heading,
      isGone ? element("p", { class: "ended" }, `Ended; this is how it was at ${format.utc(track.time)} UTC`) : null,
      entries,
      element("h3", {}, why[track.source] ?? "Contributors"),
      contributors(track, this.whole?.id === track.id ? this.whole : null, this.info, decide),
      ...decided(track, this.decisions, decide),
      this.verdicts.section(track, mayDecide ? (transponder, verdict) => this.judge(transponder, verdict) : null),
      this.said?.id === selected ? element("p", { role: "status" }, this.said.text) : null,
    ].filter((part) => part !== null);
  }
}
