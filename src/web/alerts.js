// The alerts: which there are, how many of them somebody has to look at, and the panel that they are in.

import { askForAnother, hasToken, list } from "./api.js";
import { tracksOf } from "./alertitem.js";
import { AlertHistory } from "./alerthistory.js";
import { AlertList, sorted } from "./alertlist.js";
import { byId, setAttribute, setText } from "./dom.js";
import * as format from "./format.js";
import { News } from "./news.js";
import { Sound } from "./sound.js";

const isCritical = ({ severity }) => severity === "critical";
const isQuiet = ({ acknowledged, shelved }) => Boolean(acknowledged ?? shelved);

export class Alerts {
  known = null; // by id; null until they were answered or one was heard
  read = null; // {state, since, why}: whether what is known is all there is
  site = "";
  mayControl = null; // whether the reader may do something about alerts; null while that is not known

  /** `changed` is given the severity by track; `renewHistory` asks for the alerts that ended. */
  constructor(changed, renewHistory) {
    Object.assign(this, { changed, renewHistory });
    this.panel = byId("alerts");
    this.button = byId("alerts-button");
    this.button.addEventListener("click", () => this.toggle());
    byId("alerts-close").addEventListener("click", () => this.toggle());
    byId("alert-bar-token").addEventListener("click", askForAnother);
    this.history = new AlertHistory(renewHistory);
    this.list = new AlertList({ bar: () => this.bar(), took: (alert) => this.update(alert), hasToken });
    this.sound = new Sound(() => this.waiting().some(isCritical));
    this.news = new News({ open: () => this.open(true), changed: () => this.showTitle(), told: (alert) => this.sound.note(alert) });
    this.show();
  }

  /** Whoever asks for the panel is in it then, and back where he came from when it is closed. */
  open(isOpen) {
    this.panel.hidden = !isOpen;
    setAttribute(this.button, "aria-expanded", String(isOpen));
    if (isOpen) {
      this.news.seen();
      this.cameFrom = document.activeElement;
      this.panel.focus();
    } else if (this.cameFrom?.isConnected) {
      this.cameFrom.focus();
    }
    this.renewHistory();
  }

  toggle() {
    this.open(this.panel.hidden);
  }

  /** Whether the keyboard is in the panel. */
  get hasFocus() {
    return this.panel.contains(document.activeElement);
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
    if (alert.until) {
      this.known.delete(alert.id);
      this.news.over(alert);
      this.renewHistory();
    } else {
      this.compare(this.known.get(alert.id), alert);
      this.known.set(alert.id, alert);
    }
    this.show();
  }

  /** A service that has started anew counts its alerts from the first one again. */
  compare(before, alert) {
    if (isQuiet(alert)) return this.news.settle(alert);
    const isWorse = isCritical(alert) && !isCritical(before ?? alert);
    if (before?.since !== alert.since || isWorse || isQuiet(before)) this.news.note(alert, !this.panel.hidden);
  }

  /** Whether the answer of /alerts is known. */
  setRead(read) {
    this.read = read;
    this.show();
  }

  setControl(mayControl) {
    this.mayControl = mayControl;
    this.show();
  }

  /** Why the reader's buttons do nothing; "" where they do. */
  bar() {
    if (this.mayControl === null) return "Whether you may acknowledge and shelve alerts is not known yet.";
    return this.mayControl ? "" : "Your token may only read: to acknowledge and shelve takes one with the scope “control”.";
  }

  /** Those that nobody has acknowledged or shelved. */
  waiting() {
    return [...(this.known?.values() ?? [])].filter((alert) => !isQuiet(alert));
  }

  /** How many of those there are, as the page says it. */
  get count() {
    return this.read?.state === "good" ? String(this.waiting().length) : "?";
  }

  show() {
    const all = sorted(this.known?.values() ?? []);
    setText(byId("alert-count"), this.count);
    setAttribute(this.button, "data-severity", sorted(this.waiting())[0]?.severity ?? "none");
    setText(byId("alert-words"), this.read?.state === "good" && all.length ? `${all.length} (${this.count} not acknowledged)` : "");
    this.showTitle();
    setText(byId("alert-note"), this.note());
    this.list.show(all);
    const byTrack = new Map();
    for (const alert of all.filter(({ shelved }) => !shelved)) {
      for (const track of tracksOf(alert)) if (!byTrack.has(track)) byTrack.set(track, alert.severity);
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

  /** The title is all that is seen of a page behind another one: the count first, with a mark where any is critical. */
  showTitle() {
    const { worst } = this.news;
    const mark = this.waiting().some(isCritical) ? "!" : "";
    const count = this.read?.state === "failed" || Number(this.count) ? `(${this.count}${mark}) ` : "";
    const news = worst ? `${worst.text ?? worst.kind} – ` : "";
    const title = `${count}${news}${this.site ? `${this.site} – ` : ""}utm-fusion`;
    if (document.title !== title) document.title = title;
  }
}
