// Two tones: one for a warning, and one for a critical alert, repeated until it is acknowledged or shelved. Browsers allow sound
// only after the user has interacted with the page.

import { byId, setText } from "./dom.js";
import { change, onChange, settings } from "./settings.js";

/** Notes of the tones: frequency in Hz, start and length in s. They differ in rhythm as well as in pitch (by judgement). */
const TONES = {
  warning: [[660, 0, 0.16], [520, 0.2, 0.3]],
  critical: [[880, 0, 0.12], [1175, 0.16, 0.12], [880, 0.32, 0.12], [1175, 0.48, 0.12], [880, 0.64, 0.24]],
};
const AGAIN_MS = 4000; // interval of the critical tone, by judgement
const APART_MS = 1000; // alerts within this time are one tone
const TICK_MS = 500;
const LOUDNESS = 0.25; // of the maximum
const EDGE_S = 0.015; // abrupt edges of a note would click

export class Sound {
  /** @type {AudioContext | null} */
  context = null; // while sound is on
  playedAt = -Infinity; // on the page's monotonic clock

  /** `isAlarming`: whether a critical alert is neither acknowledged nor shelved. @param {() => boolean} isAlarming */
  constructor(isAlarming) {
    this.isAlarming = isAlarming;
    this.box = byId("sound", HTMLInputElement);
    this.box.addEventListener("change", () => {
      change({ sound: this.box.checked });
      if (this.box.checked) this.test();
    });
    const blocked = byId("sound-blocked");
    blocked.addEventListener("click", () => this.test());
    // Any touch unblocks the sound, except of this button: it would disappear before its click.
    for (const type of ["pointerdown", "keydown"]) addEventListener(type, ({ target }) => target !== blocked && this.context?.resume(), { passive: true });
    onChange((patch) => "sound" in patch && this.follow());
    setInterval(() => this.tick(), TICK_MS);
    this.follow();
  }

  /** Applies the setting. */
  follow() {
    this.box.checked = settings.sound;
    if (settings.sound && !this.context) {
      this.context = new AudioContext();
      this.context.addEventListener("statechange", () => this.show());
    } else if (!settings.sound && this.context) {
      this.context.close();
      this.context = null;
    }
    this.show();
  }

  get isBlocked() {
    return this.context !== null && this.context.state !== "running";
  }

  /** Shows whether sound can be heard, because a user who relies on it must not be wrong. */
  show() {
    byId("sound-blocked").hidden = !this.isBlocked;
    if (!this.isBlocked) setText(byId("sound-state"), "");
    else setText(byId("sound-state"), "The browser blocks the sound of the alerts");
  }

  /** Plays a tone when sound is switched on. */
  async test() {
    await this.context?.resume();
    this.play("warning");
  }

  /** Takes a new alert. @param {Alert} alert */
  note({ severity }) {
    if (performance.now() - this.playedAt >= APART_MS) this.play(severity === "critical" ? "critical" : "warning");
  }

  tick() {
    if (this.isAlarming() && performance.now() - this.playedAt >= AGAIN_MS) this.play("critical");
  }

  /** Plays a tone, unless the browser would delay it, since it would be outdated then. @param {Severity} name */
  play(name) {
    this.show();
    if (!this.context || this.isBlocked) return;
    this.playedAt = performance.now();
    const begin = this.context.currentTime;
    for (const [frequency, at, length] of TONES[name]) {
      const [from, to] = [begin + at, begin + at + length];
      const note = new OscillatorNode(this.context, { frequency });
      const volume = new GainNode(this.context, { gain: 0 });
      volume.gain.setValueAtTime(0, from).linearRampToValueAtTime(LOUDNESS, from + EDGE_S);
      volume.gain.setValueAtTime(LOUDNESS, to - EDGE_S).linearRampToValueAtTime(0, to);
      note.connect(volume).connect(this.context.destination);
      note.start(from);
      note.stop(to);
    }
  }
}
