// Condition of the service as the badge and an empty map state it: the state that /readyz and CAT065 have, and the silent sensors.

import * as format from "./format.js";

const MOST = 3; // maximum number of sensors that a message names
const NO_SLOT = "no slot has been published yet";

/** Last answer of /status, and the states of the sensors. */
export class Condition {
  /** @type {StatusAnswer | null} */
  answer = null;
  isKnown = false;
  /** @type {SensorProperties[]} */
  sensors = [];

  /** Takes the answer of /status. @param {StatusAnswer} answer */
  take(answer) {
    if (typeof answer?.state !== "string") throw new Error("the answer has no state");
    this.answer = answer;
  }

  get silent() {
    return this.sensors.filter(({ state }) => state === "outage");
  }

  /** Whether no sensor delivers anything, or no picture exists. */
  get hasNoData() {
    return (this.sensors.length > 0 && this.silent.length === this.sensors.length) || this.hasNoPicture;
  }

  get hasNoPicture() {
    return this.answer?.ready === false && (this.answer.reasons ?? []).includes(NO_SLOT);
  }

  /** Severity: "ok", "warning" or "critical". */
  get level() {
    if (!this.isKnown || !this.answer) return "warning";
    if (this.answer.ready === false || this.hasNoData) return "critical";
    return this.answer.state === "ok" ? "ok" : "warning";
  }

  /** Time of the last report of any sensor, in ms since 1970; NaN if there was none. */
  get lastSeen() {
    const times = this.sensors.map(({ last_seen }) => Date.parse(last_seen)).filter(Number.isFinite);
    return times.length ? Math.max(...times) : NaN;
  }

  /** Reasons of the service, as one text. */
  get reasons() {
    if (!this.isKnown || !this.answer) return "the state of the service is not known";
    return (this.answer.reasons ?? []).join("; ") || "no reason was given";
  }

  /** "radar silent since 2026-03-14 03:15:20 UTC"; "" while every sensor delivers. @param {number} now */
  silence(now) {
    const { silent } = this;
    if (silent.length <= MOST) return silent.map((sensor) => silenceOf(sensor, now)).join("; ");
    const who = silent.length === this.sensors.length ? `all ${silent.length} sensors` : `${silent.length} of ${this.sensors.length} sensors`;
    const times = silent.map(({ last_seen }) => Date.parse(last_seen)).filter(Number.isFinite);
    return times.length ? `${who} silent since ${format.moment(Math.max(...times), now)}` : `nothing received from ${who}`;
  }
}

/** @param {SensorProperties} sensor @param {number} now */
function silenceOf({ id, last_seen }, now) {
  const time = Date.parse(last_seen);
  return Number.isFinite(time) ? `${id} silent since ${format.moment(time, now)}` : `nothing received from ${id}`;
}
