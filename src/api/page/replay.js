// Play, pause, seek and speed of a recording that the service replays.

import { post } from "./api.js";
import { byId, element, setText } from "./dom.js";
import * as format from "./format.js";

const SPEEDS = [0.25, 0.5, 1, 2, 4, 8, 16];

export class Replay {
  state = { playing: true, speed: 1, start: null, end: null };
  time = NaN;
  held = false; // the slider is in the user's hand

  constructor(status) {
    this.status = status;
    this.slider = byId("replay-position");
    for (const speed of SPEEDS) byId("replay-speed").append(element("option", { value: speed, selected: speed === 1 }, `×${speed}`));
    byId("replay-toggle").addEventListener("click", () => this.toggle());
    byId("replay-back").addEventListener("click", () => this.seek(this.time - 10000));
    byId("replay-forward").addEventListener("click", () => this.seek(this.time + 10000));
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
    toggle.setAttribute("aria-label", playing ? "Pause" : "Play");
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

  at(time) {
    this.time = time;
    const gone = (time - Date.parse(this.state.start)) / 1000;
    if (!this.held && Number.isFinite(gone)) this.slider.value = String(gone);
    setText(byId("replay-at"), format.clock(this.held ? Number(this.slider.value) : gone));
  }

  toggle() {
    this.ask(this.state.playing ? "pause" : "play", {}, { playing: !this.state.playing });
  }

  seek(time) {
    if (Number.isFinite(time)) this.ask("seek", { time: new Date(time).toISOString() });
  }

  /** A time of day, on the day that the picture shows. */
  typed(text) {
    const [h, m, s = 0] = text.split(":").map(Number);
    return new Date(this.time).setUTCHours(0, 0, 0, 0) + ((h * 60 + m) * 60 + s) * 1000;
  }

  async ask(what, body, expected = body) {
    try {
      const answer = await post(`replay/${what}`, body);
      setText(byId("replay-error"), "");
      this.update({ ...expected, ...answer });
    } catch (error) {
      setText(byId("replay-error"), error.message);
    }
  }
}
