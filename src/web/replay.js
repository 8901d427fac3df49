// Play, pause, seek and speed of a recording that the service replays.

import { post } from "./api.js";
import { byId, element, setText } from "./dom.js";
import * as format from "./format.js";

const SPEEDS = [0.25, 0.5, 1, 2, 4, 8, 16];
const ARRIVED_MS = 1500; // the picture is at most this far from the time that was asked for
const LONGEST_SEEK_MS = 5000;

export class Replay {
  state = { playing: true, speed: 1, start: null, end: null };
  time = NaN;
  held = false; // the slider is in the user's hand
  wanted = null; // where it was asked to go and is not yet, ms since 1970
  isSeeking = false; // and the service has not answered yet

  constructor(status) {
    this.status = status;
    this.slider = byId("replay-position");
    for (const speed of SPEEDS) byId("replay-speed").append(element("option", { value: speed, selected: speed === 1 }, `×${speed}`));
    byId("replay-toggle").addEventListener("click", () => this.toggle());
    byId("replay-back").addEventListener("click", () => this.skip(-10000));
    byId("replay-forward").addEventListener("click", () => this.skip(10000));
    byId("replay-speed").addEventListener("change", (event) => this.ask("speed", { speed: Number(event.target.value) }));
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
      this.seek(this.typed(byId("replay-time").value));
    });
  }

  /** The `replay` of /info, or of an answer. */
  update(state) {
    this.state = { ...this.state, ...state };
    this.status.replay = this.state;
    byId("replay").hidden = !this.status.isReplay;
    const { playing, speed, start, end } = this.state;
    const toggle = byId("replay-toggle");
    setText(toggle, playing ? "Pause" : "Play");
    this.showSpeed(speed);
    const length = (Date.parse(end) - Date.parse(start)) / 1000;
    this.slider.disabled = !Number.isFinite(length); // until the service has read the recording through
    if (Number.isFinite(length)) this.slider.max = String(length);
    setText(byId("replay-length"), format.clock(length));
    this.at(this.time);
    this.status.show();
  }

  /** Any speed may have been asked for on the command line. */
  showSpeed(speed) {
    const select = byId("replay-speed");
    if (![...select.options].some((option) => Number(option.value) === speed)) {
      select.append(element("option", { value: speed }, `×${speed}`));
    }
    select.value = String(speed);
  }

  /** The time that the picture shows. Until it shows the one that was asked for, that one is shown. */
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

  /** From where it was asked to go last: three times 10 s are 30 s, however slowly the service answers. */
  skip(ms) {
    this.seek((this.wanted ?? this.time) + ms);
  }

  async seek(time) {
    if (!Number.isFinite(time)) return;
    const [first, last] = [Date.parse(this.state.start), Date.parse(this.state.end)];
    this.wanted = Math.max(Number.isFinite(first) ? first : time, Math.min(Number.isFinite(last) ? last : time, time));
    this.at(this.time);
    if (this.isSeeking) return; // one at a time, so that the last one asked for is the last one done
    this.isSeeking = true;
    let [asked, isDone] = [null, true];
    while (isDone && this.wanted !== asked) {
      asked = this.wanted;
      isDone = await this.ask("seek", { time: new Date(asked).toISOString() });
    }
    this.isSeeking = false;
    if (!isDone) this.wanted = null;
    // Between the end of the recording and its last picture it never arrives.
    clearTimeout(this.giveUp);
    this.giveUp = setTimeout(() => (this.wanted = null), LONGEST_SEEK_MS);
    this.at(this.time);
  }

  /** A time of day, on the day that the picture shows. */
  typed(text) {
    const [h, m, s = 0] = text.split(":").map(Number);
    return new Date(this.time).setUTCHours(0, 0, 0, 0) + ((h * 60 + m) * 60 + s) * 1000;
  }

  /** Whether it is done. */
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
