// Play, pause, seek and speed controls of a replayed recording.

import { post } from "./api.js";
import { byId, element, setText } from "./dom.js";
import * as format from "./format.js";

const SPEEDS = [0.25, 0.5, 1, 2, 4, 8, 16];
const ARRIVED_MS = 1500; // tolerance between the picture's time and the requested time
const LONGEST_SEEK_MS = 5000;
const EDGE_MS = 1000; // a typed time has whole seconds, a recording has not
const DAY_MS = 86400000;
const TYPED = /^(?:(\d{4}-\d\d-\d\d)[T ])?([01]?\d|2[0-3]):([0-5]\d)(?::([0-5]\d(?:\.\d+)?))?Z?$/;

export class Replay {
  /** @type {ReplayState} */
  state = { playing: true, speed: 1, ended: false };
  time = NaN;
  held = false; // the user holds the slider
  /** @type {number | null} */
  wanted = null; // requested time that is not reached yet, in ms since 1970
  isSeeking = false; // a seek request is pending

  /** @param {Status} status */
  constructor(status) {
    this.status = status;
    this.slider = byId("replay-position", HTMLInputElement);
    const speeds = byId("replay-speed", HTMLSelectElement);
    for (const speed of SPEEDS) speeds.append(element("option", { value: speed, selected: speed === 1 }, `×${speed}`));
    byId("replay-toggle").addEventListener("click", () => this.toggle());
    byId("replay-back").addEventListener("click", () => this.skip(-10000));
    byId("replay-forward").addEventListener("click", () => this.skip(10000));
    speeds.addEventListener("change", () => this.ask("speed", { speed: Number(speeds.value) }));
    this.slider.addEventListener("input", () => {
      this.held = true;
      this.at(this.time);
    });
    this.slider.addEventListener("change", () => {
      this.held = false;
      this.seek(Date.parse(this.state.start) + Number(this.slider.value) * 1000);
    });
    byId("replay-seek").addEventListener("submit", (event) => {
      event.preventDefault();
      this.seekTyped(byId("replay-time", HTMLInputElement).value.trim());
    });
  }

  /** Takes the `replay` of /info, or of an answer. @param {Partial<ReplayState>} state */
  update(state) {
    this.state = { ...this.state, ...state };
    this.status.replay = this.state;
    byId("replay").hidden = !this.status.isReplay;
    const { playing, speed, start, end } = this.state;
    const toggle = byId("replay-toggle");
    setText(toggle, playing ? "Pause" : "Play");
    this.showSpeed(speed);
    const length = (Date.parse(end) - Date.parse(start)) / 1000;
    this.slider.disabled = !Number.isFinite(length); // until the service has read the whole recording
    if (Number.isFinite(length)) this.slider.max = String(length);
    setText(byId("replay-length"), format.clock(length));
    this.at(this.time);
    this.status.show();
  }

  /** The command line allows any speed. @param {number} speed */
  showSpeed(speed) {
    const select = byId("replay-speed", HTMLSelectElement);
    if (![...select.options].some((option) => Number(option.value) === speed)) {
      select.append(element("option", { value: speed }, `×${speed}`));
    }
    select.value = String(speed);
  }

  /** Takes the time of the picture. A requested time is shown until the picture reaches it. @param {number} time */
  at(time) {
    this.time = time;
    if (this.wanted != null && !this.isSeeking && Math.abs(time - this.wanted) < ARRIVED_MS) this.wanted = null;
    const gone = ((this.wanted ?? time) - Date.parse(this.state.start)) / 1000;
    if (!this.held && Number.isFinite(gone)) this.slider.value = String(gone);
    setText(byId("replay-at"), format.clock(this.held ? Number(this.slider.value) : gone));
  }

  toggle() {
    this.ask(this.state.playing ? "pause" : "play", {}, { playing: !this.state.playing });
  }

  /** Skips from the time requested last: three times 10 s are 30 s, however slow the service is. @param {number} ms */
  skip(ms) {
    this.seek((this.wanted ?? this.time) + ms);
  }

  /** @param {number} time */
  async seek(time) {
    if (!Number.isFinite(time)) return;
    const [first, last] = [Date.parse(this.state.start), Date.parse(this.state.end)];
    this.wanted = Math.max(Number.isFinite(first) ? first : time, Math.min(Number.isFinite(last) ? last : time, time));
    this.at(this.time);
    if (this.isSeeking) return; // one request at a time, so that the last one takes effect last
    this.isSeeking = true;
    let [asked, isDone] = [NaN, true];
    while (isDone && this.wanted !== null && this.wanted !== asked) {
      asked = this.wanted;
      isDone = await this.ask("seek", { time: new Date(asked).toISOString() });
    }
    this.isSeeking = false;
    if (!isDone) this.wanted = null;
    // A time between the end of the recording and its last picture is never reached.
    clearTimeout(this.giveUp);
    this.giveUp = setTimeout(() => (this.wanted = null), LONGEST_SEEK_MS);
    this.at(this.time);
  }

  /** Seeks to a typed time, or says why not. @param {string} text */
  seekTyped(text) {
    const [first, last] = [Date.parse(this.state.start), Date.parse(this.state.end)];
    const times = timesOf(text, first, last, this.time);
    const said = times.length ? notIn(first, last) : "Not a time: write hh:mm:ss, or a date and a time such as 2026-03-14 09:01:20 (UTC)";
    const fitting = times.filter((time) => !(time < first - EDGE_MS || time > last + EDGE_MS));
    setText(byId("replay-error"), fitting.length ? "" : said);
    // In a recording of several days the nearest one is meant.
    if (fitting.length) this.seek(fitting.reduce((one, other) => (Math.abs(other - this.time) < Math.abs(one - this.time) ? other : one)));
  }

  /**
   * Sends an order. Returns whether it was done.
   * @param {"play" | "pause" | "seek" | "speed"} what @param {Record<string, number | string>} body
   * @param {object} [expected]
   */
  async ask(what, body, expected = body) {
    try {
      const answer = await post(`replay/${what}`, body);
      setText(byId("replay-error"), "");
      this.update({ ...expected, ...answer });
      return true;
    } catch (error) {
      setText(byId("replay-error"), `Not done: ${error.message}`);
      return false;
    }
  }
}

/**
 * UTC times that a typed text can mean: with a date one; without, that time on each day of the recording. None if it is no time.
 * @param {string} text @param {number} first @param {number} last @param {number} shown
 */
function timesOf(text, first, last, shown) {
  const [, date, h, m, s = 0] = TYPED.exec(text) ?? [];
  if (h === undefined) return [];
  const ofDay = ((Number(h) * 60 + Number(m)) * 60 + Number(s)) * 1000;
  if (date) return Number.isFinite(Date.parse(date)) ? [Date.parse(date) + ofDay] : [];
  /** @param {number} time */
  const dayOf = (time) => Math.floor(time / DAY_MS) * DAY_MS;
  const [from, to] = [first, last].map((time) => dayOf(Number.isFinite(time) ? time : shown));
  const days = [];
  for (let day = from; day <= to; day += DAY_MS) days.push(day + ofDay);
  return days;
}

/** @param {number} first @param {number} last */
const notIn = (first, last) =>
  `Not in the recording, which is from ${format.date(first)} ${format.utc(first)} to ${format.date(last)} ${format.utc(last)} UTC`;
