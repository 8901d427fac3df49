// The badge and the clock: whether what is shown is live, from a recording, or old.

import { byId, setAttribute, setText } from "./dom.js";
import * as format from "./format.js";

const STALE_MS = 3000; // the service sends something each second
const PREDICTED = "each track is where it should be by now; it is within its ellipse 95 times of 100, and those less sure are left out";

export class Status {
  info = null;
  heardAt = null; // the page's monotonic clock
  publishedAt = null; // the page's monotonic clock and the service's UTC at the same moment
  pictureTime = NaN;
  latency = NaN;
  isNow = false; // the picture is predicted, of now
  replay = null; // {speed, playing}
  past = null; // the time of the past picture that is shown, ms since 1970
  late = null; // seconds, while the service says that its picture is late
  retry = null;
  isBroken = false; // the stream has ended, and no new one has begun

  constructor() {
    setInterval(() => this.show(), 250);
    document.addEventListener("visibilitychange", () => this.show());
  }

  /** A collection of tracks came. */
  took(collection) {
    this.isNow = collection.at === "now";
    this.heard(collection);
  }

  heard({ time, published_at, latency_s }) {
    this.heardAt = performance.now();
    this.retry = null;
    if (published_at) this.publishedAt = [this.heardAt, Date.parse(published_at)];
    if (Number.isFinite(latency_s)) this.latency = latency_s;
    if (time && Number.isFinite(Date.parse(time))) this.pictureTime = Date.parse(time);
    this.show();
  }

  /** The stream has ended; the next attempt is in so many seconds. */
  failed(retry) {
    this.retry = retry;
    this.isBroken = true;
    this.show();
  }

  /** A new stream has begun, with the whole picture. */
  began() {
    this.isBroken = false;
  }

  /** Each second: also where no picture comes. */
  beat(beat) {
    this.late = beat.late_s ?? null;
    this.heard(this.isNow ? {} : beat); // its times are those of the other picture
  }

  get isReplay() {
    return this.info?.mode === "replay";
  }

  get isStale() {
    return this.heardAt != null && (this.isBroken || performance.now() - this.heardAt > STALE_MS);
  }

  /** UTC by the service's clock where it told it, which counts; else by this machine's. */
  utc() {
    if (!this.publishedAt) return Date.now();
    return this.publishedAt[1] + performance.now() - this.publishedAt[0];
  }

  show() {
    const [state, text, title] = this.words();
    const badge = byId("badge");
    setAttribute(badge, "data-state", state);
    setText(badge, text);
    setAttribute(badge, "title", title);
    setText(byId("announcement"), `${state}: ${title}`); // said once, not at each second of the badge
    document.body.classList.toggle("past", state === "past");
    document.body.classList.toggle("stale", state === "stale" || state === "late"); // old positions must not look like new ones
    const [clock, beside, meaning] = this.times();
    setText(byId("utc"), `${format.utc(clock)} UTC`);
    setText(byId("picture-time"), beside);
    setAttribute(byId("utc"), "title", meaning);
  }

  /** The clock, what stands beside it, and what the clock is. In a recording the only time that counts is its own. */
  times() {
    if (this.isReplay) return [this.pictureTime, format.date(this.pictureTime), "The time in the recording"];
    const picture = Number.isFinite(this.pictureTime) ? `picture ${format.utc(this.pictureTime, 1)}` : "";
    return [this.utc(), picture, "Now; beside it the time that the picture shows"];
  }

  words() {
    if (this.heardAt == null) {
      const wait = this.retry ? `; next attempt in ${format.seconds(this.retry, 0)}` : "";
      return ["connecting", "CONNECTING", `No word from the service yet${wait}`];
    }
    if (this.isStale) {
      const silent = (performance.now() - this.heardAt) / 1000;
      return ["stale", `STALE since ${format.utc(Date.now() - silent * 1000)} (${format.duration(silent)})`, "Nothing was heard from the service; what is shown is old. The page keeps trying."];
    }
    if (this.past !== null) return ["past", `PAST ${format.utc(this.past)}`, "A picture from the history, not the world now; who is who is as known now. “Back to live” ends it"];
    if (!this.info) return ["connecting", "LIVE OR REPLAY?", "The service has not said yet whether this is live or a recording"];
    if (this.isReplay) {
      const { speed, playing } = this.replay ?? {};
      const how = playing === false ? " paused" : speed && speed !== 1 ? ` ×${speed}` : "";
      const predicted = this.isNow ? " NOW (predicted)" : "";
      return ["replay", `REPLAY${how}${predicted}`, `A recording, not the world now${this.isNow ? `; ${PREDICTED}` : ""}`];
    }
    if (this.late != null) {
      const late = this.late < 10 ? this.late.toFixed(1) : this.late.toFixed(0);
      return ["late", `LATE ${late} s`, "The service publishes later than it should: every track was somewhere else by now. The alerts say why."];
    }
    if (this.isNow) return ["now", "NOW (predicted)", PREDICTED];
    const behind = Number.isFinite(this.latency) ? ` −${this.latency.toFixed(2)} s` : "";
    return ["live", `LIVE${behind}`, "The picture is this far behind the world, so that late measurements still count"];
  }
}
