// The badge and the clock: one condition of what is shown, the worst of all.

import { ServiceClock } from "./clock.js";
import { Condition } from "./condition.js";
import { byId, setAttribute, setText } from "./dom.js";
import * as format from "./format.js";

const STALE_MS = 3000; // the service sends an event every second
const UPDATE_S = 1; // time between two pictures in the stream
const NOW_S = 0.25; // usual age of a predicted picture: one slot
const [LATE_S, ON_TIME_S] = [1, 0.5]; // delays at which a picture becomes late, and is on time again; as in the service
const PREDICTED = "Each track is at its predicted present position. It is within its ellipse with 95 % probability. Less certain tracks are left out.";

export class Status {
  /** @type {Info | null} */
  info = null;
  /** @type {number | null} */
  heardAt = null; // on the page's monotonic clock
  /** @type {number | null} */
  shownAt = null; // moment at which the shown picture was received, on the same clock
  pictureTime = NaN; // time of the shown picture
  latency = NaN; // latency of the shown picture as reported by the service, in seconds
  isNow = false; // the picture is the predicted one, "now"
  /** @type {ReplayState | null} */
  replay = null;
  /** @type {number | null} */
  past = null; // time of the past picture shown, in ms since 1970
  /** @type {number | null} */
  late = null; // delay in seconds, while the service reports the picture as late
  wasLate = false; // by the page's own estimate
  /** @type {number | null} */
  retry = null; // seconds
  isBroken = false; // the stream has ended, and no new one has started
  condition = new Condition();

  /** `jumped` is called after the display slept or its clock was set. @param {() => void} jumped */
  constructor(jumped) {
    this.clock = new ServiceClock((ms) => {
      if (this.heardAt !== null && ms > 0) this.heardAt -= ms; // nothing was received meanwhile
      jumped();
    });
    setInterval(() => this.show(), 250);
    document.addEventListener("visibilitychange", () => this.show());
  }

  /** Takes a received collection of tracks. @param {TrackCollection} collection */
  took(collection) {
    this.isNow = collection.at === "now";
    const time = Date.parse(collection.time);
    if (Number.isFinite(time)) [this.pictureTime, this.shownAt] = [time, performance.now()];
    this.heard(collection);
  }

  /** @param {{ published_at?: string, latency_s?: number }} event */
  heard({ published_at, latency_s }) {
    this.heardAt = performance.now();
    this.retry = null;
    this.clock.noted(Date.parse(published_at), this.heardAt);
    if (Number.isFinite(latency_s)) this.latency = latency_s;
    this.show();
  }

  /**
   * Takes the answer of /status to a request of that moment.
   * @param {{ answer: StatusAnswer, asked: number, received: number }} state
   */
  takeState({ answer, asked, received }) {
    this.condition.take(answer);
    if (!this.isReplay) this.clock.answered(Date.parse(answer.time), asked, received);
    this.show();
  }

  /** The stream has ended; `retry` is the time until the next attempt, in seconds. @param {number} retry */
  failed(retry) {
    this.retry = retry;
    this.isBroken = true;
    this.show();
  }

  /** A new stream has started with the whole picture. */
  began() {
    this.isBroken = false;
  }

  /** Takes a heartbeat, every second even without pictures. @param {Heartbeat} beat */
  beat(beat) {
    this.late = beat.late_s ?? null;
    this.heard(this.isNow ? {} : { latency_s: beat.latency_s }); // latency of the other picture
  }

  get isReplay() {
    return this.info?.mode === "replay";
  }

  get isStale() {
    return this.heardAt != null && (this.isBroken || performance.now() - this.heardAt > STALE_MS);
  }

  /** UTC by the service's clock if it is known; else by this machine's. */
  utc() {
    return this.clock.now();
  }

  /** Age of the shown picture when it was received, in seconds; NaN if unknown. */
  get age() {
    if (!this.clock.isKnown || this.isReplay || this.shownAt === null) return NaN;
    const waited = Math.min(UPDATE_S * 1000, performance.now() - this.shownAt);
    return (this.utc() - this.pictureTime - waited) / 1000;
  }

  /** Delay of the shown picture beyond its latency, by the page's own estimate or that of the service; null while it is on time. */
  delay() {
    const own = this.age - (this.isNow ? NOW_S : (this.info?.latency_s ?? NaN));
    this.wasLate = own > (this.wasLate ? ON_TIME_S : LATE_S);
    const delays = [this.late, this.wasLate ? own : null].filter((delay) => delay !== null);
    return delays.length ? Math.max(...delays) : null;
  }

  show() {
    const [state, text, title, level = "ok"] = this.words();
    const badge = byId("badge");
    setAttribute(badge, "data-state", state);
    setAttribute(badge, "data-level", level);
    setText(badge, text);
    setAttribute(badge, "title", title);
    setText(byId("announcement"), `${state}: ${title}`); // announced once, not at every second of the badge
    document.body.classList.toggle("past", state === "past");
    document.body.classList.toggle("stale", ["stale", "late", "no-data"].includes(state)); // old positions must not look current
    const [clock, beside, meaning] = this.times();
    setText(byId("utc"), `${format.utc(clock)} UTC`);
    setText(byId("picture-time"), beside);
    setAttribute(byId("utc"), "title", meaning);
  }

  /**
   * The clock, the time beside it, and what the clock shows. For a recording this is the time of the recording.
   * @returns {[number, string, string]}
   */
  times() {
    if (this.isReplay) return [this.pictureTime, format.date(this.pictureTime), "The time in the recording"];
    const picture = Number.isFinite(this.pictureTime) ? `picture ${format.utc(this.pictureTime, 1)}` : "";
    return [this.utc(), picture, "The present time, and beside it the time of the picture"];
  }

  /** State, text, explanation, and severity of the worst condition. @returns {[string, string, string, string?]} */
  words() {
    const { condition } = this;
    if (this.heardAt == null) {
      const wait = this.retry ? `; next attempt in ${format.seconds(this.retry, 0)}` : "";
      return ["connecting", "CONNECTING", `The service has not answered yet${wait}`];
    }
    if (this.isStale) {
      const silent = performance.now() - this.heardAt;
      return ["stale", `STALE since ${format.utc(this.utc() - silent)} (${format.duration(silent / 1000)})`, "The service does not answer. The tracks are old. The page keeps trying."];
    }
    if (this.past !== null) return ["past", `PAST ${format.utc(this.past)}`, "A picture from the history, not the present. Identities are as known now. “Back to live” ends it."];
    if (!this.info) return ["connecting", "LIVE OR REPLAY?", "It is not known yet whether this is live or a recording"];
    if (this.isReplay) return this.replayWords();
    if (condition.hasNoData) {
      const since = Number.isFinite(condition.lastSeen) ? ` since ${format.utc(condition.lastSeen)}` : "";
      return ["no-data", `NO DATA${since}`, `An empty map is not a clear sky: ${condition.silence(this.utc()) || condition.reasons}`, "critical"];
    }
    const late = this.delay();
    if (late !== null) return ["late", `LATE ${late.toFixed(late < 10 ? 1 : 0)} s`, this.lateWords(late)];
    if (!condition.isKnown && !condition.answer) return ["connecting", "CONNECTING", "The state of the service is not known yet"];
    const age = Math.max(this.latency, this.age || 0);
    const behind = this.isNow ? " NOW (predicted)" : Number.isFinite(age) ? ` −${age.toFixed(2)} s` : "";
    if (condition.level !== "ok") return ["degraded", `DEGRADED${behind}`, `Something is wrong: ${condition.reasons}`, condition.level];
    if (this.isNow) return ["now", "NOW (predicted)", PREDICTED];
    return ["live", `LIVE${behind}`, "The picture is this old, so that late measurements are included"];
  }

  /** @returns {[string, string, string]} */
  replayWords() {
    const { speed, playing } = this.replay ?? {};
    const how = playing === false ? " paused" : speed && speed !== 1 ? ` ×${speed}` : "";
    const predicted = this.isNow ? " NOW (predicted)" : "";
    return ["replay", `REPLAY${how}${predicted}`, `A recording, not the present. ${this.isNow ? PREDICTED : ""}`.trim()];
  }

  /** @param {number} late */
  lateWords(late) {
    const cause = this.late === null ? "The connection delays the picture" : "The service publishes the picture late; the alerts give the reason";
    return `${cause}: each track shows where the aircraft was ${format.duration(late)} before the usual time.`;
  }

  /** Reason why no aircraft is shown. */
  whyEmpty() {
    const { condition } = this;
    if (this.heardAt == null) return "The tracks are not known: the service has not answered yet";
    const now = this.isReplay ? this.pictureTime : this.utc();
    if (this.isStale) return `No data: the service has not answered since ${format.moment(this.utc() - (performance.now() - this.heardAt), now)}`;
    if (this.past !== null) return "No aircraft at that time";
    const silence = condition.silence(now);
    if (condition.hasNoData) return `No data: ${silence || "no picture has been published yet"}`;
    const late = this.isReplay ? null : this.delay();
    if (late !== null) return `No aircraft in a picture that is ${format.duration(late)} late`;
    if (silence) return `No aircraft seen, but not all sensors work: ${silence}`;
    if (!this.isReplay && condition.level !== "ok") return `No aircraft seen, but something is wrong: ${condition.reasons}`;
    return "No aircraft: every sensor works and sees none";
  }
}
