// Past pictures of a live service, from its history, one per second, while the stream continues in the background.

import { get } from "./api.js";
import { byId, setText } from "./dom.js";
import * as format from "./format.js";

const STEP_MS = 1000; // the history has one picture per second
const SKIP_MS = 10000;
const SPANS_MIN = [10, 60, 360, 1440];

export class Past {
  /** @type {number | null} */
  time = null; // time of the picture shown or requested, in ms since 1970; null while live
  /** @type {number | null} */
  wanted = null; // time to request after the pending answer
  latest = NaN; // time of the latest available picture
  isAsking = false;
  isPlaying = false;

  /**
   * `on.show(collection)` shows a past picture, `on.live()` returns to the present; `now()` is the latest available time.
   * @param {() => number} now @param {{ show: (collection: TrackCollection) => void, live: () => void }} on
   */
  constructor(now, on) {
    this.now = now;
    this.on = on;
    this.slider = byId("past-position", HTMLInputElement);
    byId("past-button").addEventListener("click", () => this.open());
    byId("past-live").addEventListener("click", () => this.close());
    byId("past-toggle").addEventListener("click", () => this.play(!this.isPlaying));
    byId("past-back").addEventListener("click", () => this.skip(-SKIP_MS));
    byId("past-forward").addEventListener("click", () => this.skip(SKIP_MS));
    byId("past-span").addEventListener("change", () => this.show());
    this.slider.addEventListener("input", () => this.go(this.latest + Number(this.slider.value) * 1000));
    for (const minutes of SPANS_MIN) {
      const option = new Option(minutes < 60 ? `${minutes} min` : `${minutes / 60} h`, String(minutes), minutes === 60, minutes === 60);
      byId("past-span").append(option);
    }
    setInterval(() => this.isPlaying && this.skip(STEP_MS), STEP_MS);
  }

  /** Length of the history in hours; undefined if none is kept. @param {number} [hours] */
  offer(hours = 0) {
    byId("past-button").hidden = !(hours > 0);
    const most = Math.max(SPANS_MIN[0], hours * 60);
    for (const option of byId("past-span", HTMLSelectElement).options) option.hidden = Number(option.value) > most;
  }

  get isOn() {
    return this.time !== null;
  }

  open() {
    byId("tools").hidePopover();
    this.latest = this.now();
    if (this.isOn || !Number.isFinite(this.latest)) return;
    byId("past").hidden = false;
    this.play(false);
    this.go(this.latest - SKIP_MS);
  }

  close() {
    this.time = this.wanted = null;
    this.play(false);
    byId("past").hidden = true;
    this.on.live();
  }

  /** @param {boolean} isPlaying */
  play(isPlaying) {
    this.isPlaying = isPlaying;
    setText(byId("past-toggle"), isPlaying ? "Pause" : "Play");
  }

  /** @param {number} ms */
  skip(ms) {
    if (this.time !== null) this.go(this.time + ms);
  }

  /** One request at a time. Of those made meanwhile the last one is sent. @param {number} time */
  async go(time) {
    this.latest = this.now();
    this.wanted = this.time = Math.min(time, this.latest);
    this.show();
    if (this.isAsking) return;
    this.isAsking = true;
    while (this.wanted !== null) {
      const asked = this.wanted;
      this.wanted = null;
      await this.ask(asked);
    }
    this.isAsking = false;
  }

  /** @param {number} time */
  async ask(time) {
    try {
      const collection = await get(`snapshot?time=${new Date(time).toISOString()}`);
      if (this.isOn) this.on.show(collection);
      setText(byId("past-error"), "");
    } catch (error) {
      this.play(false);
      setText(byId("past-error"), `Not shown: ${error.message}`);
    }
  }

  show() {
    const span = Number(byId("past-span", HTMLSelectElement).value) * 60;
    this.slider.min = String(-span);
    if (this.time === null) return;
    this.slider.value = String((this.time - this.latest) / 1000);
    setText(byId("past-at"), `${format.date(this.time)} ${format.utc(this.time)}`);
  }
}
