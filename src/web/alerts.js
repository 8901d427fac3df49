// The alerts: the worst first, their count always in sight.

import { list } from "./api.js";
import { byId, element, setAttribute, setText } from "./dom.js";
import * as format from "./format.js";
import { News } from "./news.js";
import { change } from "./settings.js";

const RANK = { critical: 0, warning: 1, info: 2 };
const MOST = 200; // shown; the count tells of the rest
const OVER = ["ended", "cleared", "resolved"];

const rank = ({ severity }) => RANK[severity] ?? 3;

export class Alerts {
  known = null; // by id; null until they were answered or one was heard
  read = null; // {state, since, why}: whether what is known is all there is
  site = "";

  /** `changed` is told the severity by track. */
  constructor(changed) {
    this.changed = changed;
    this.panel = byId("alerts");
    this.button = byId("alerts-button");
    this.button.addEventListener("click", () => this.open(this.panel.hidden));
    this.news = new News(() => this.open(true, true), () => this.showTitle());
    this.show();
  }

  /** Shows the panel or not; `isWanted`: whoever asked for it wants to be there. */
  open(isOpen, isWanted = false) {
    this.panel.hidden = !isOpen;
    setAttribute(this.button, "aria-expanded", String(isOpen));
    if (isOpen) this.news.seen();
    if (isWanted) this.panel.focus();
  }

  /** The answer of /alerts: what it does not name is over. */
  replace(answer) {
    const before = this.known;
    this.known = new Map(list(answer, "alerts").map((alert) => [alert.id, alert]));
    // What was there before the page was is no news.
    for (const alert of this.known.values()) if (before) this.compare(before.get(alert.id), alert);
    for (const alert of before?.values() ?? []) if (!this.known.has(alert.id)) this.news.over(alert);
    this.show();
  }

  update(alert) {
    this.known ??= new Map();
    if (alert.until || OVER.includes(alert.state)) {
      this.known.delete(alert.id);
      this.news.over(alert);
    } else {
      this.compare(this.known.get(alert.id), alert);
      this.known.set(alert.id, alert);
    }
    this.show();
  }

  /** A service that has started anew counts its alerts from the first one again. */
  compare(before, alert) {
    if (before?.since !== alert.since || rank(alert) < rank(before)) this.news.note(alert, !this.panel.hidden);
  }

  /** Whether the answer of /alerts is known. */
  setRead(read) {
    this.read = read;
    this.show();
  }

  /** How many there are, as the page says it. */
  get count() {
    return this.read?.state === "good" ? String(this.known.size) : "?";
  }

  show() {
    const sorted = [...(this.known?.values() ?? [])].sort(
      (a, b) => rank(a) - rank(b) || String(b.since).localeCompare(String(a.since)),
    );
    setText(byId("alert-count"), this.count);
    setAttribute(this.button, "data-severity", sorted[0]?.severity ?? "none");
    this.showTitle();
    const note = this.note();
    const shown = JSON.stringify([note, sorted]);
    if (shown === this.shown) return; // or whoever has a finger or the focus on one would lose it
    this.shown = shown;
    const items = sorted.slice(0, MOST).map((alert) => item(alert));
    if (note) items.unshift(element("li", { class: "empty" }, note));
    byId("alert-list").replaceChildren(...items);
    const byTrack = new Map();
    for (const { track_id, track = track_id, severity } of sorted) {
      if (track && severity !== "info" && !byTrack.has(track)) byTrack.set(track, severity);
    }
    this.changed(byTrack);
  }

  /** What the list alone does not say. */
  note() {
    const { state, since, why } = this.read ?? { state: "unknown" };
    if (state === "unknown") return "Not known yet";
    if (state === "failed") return `Not known since ${format.utc(since)} UTC (${why}); there may be others than these`;
    return this.known.size ? "" : "None";
  }

  /** The title is all that is seen of a page behind another one. */
  showTitle() {
    const { worst } = this.news;
    const count = this.read?.state === "failed" || Number(this.count) ? `(${this.count}) ` : "";
    const news = worst ? `${worst.text ?? worst.kind} – ` : "";
    const title = `${count}${news}${this.site ? `${this.site} – ` : ""}utm-fusion`;
    if (document.title !== title) document.title = title;
  }
}

function item({ severity, kind, text, since, track_id, track = track_id }) {
  const head = element("span", { class: "severity" }, `${severity}`);
  const body = element("span", {}, ` ${text ?? kind}`);
  const when = element("small", {}, `${(kind ?? "").replaceAll("_", " ")} · since ${format.utc(Date.parse(since))}`);
  const content = [head, body, when];
  if (!track) return element("li", { "data-severity": severity }, ...content);
  const button = element("button", { type: "button", title: `Select ${track}` }, ...content);
  button.addEventListener("click", () => change({ selected: track }));
  return element("li", { "data-severity": severity }, button);
}
