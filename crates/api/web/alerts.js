// Active alerts: their state, the number that need attention, and their panel.

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
  known = null; // by id; null until the first answer or event
  read = null; // {state, since, why}: whether the known alerts are complete
  site = "";
  mayControl = null; // whether the user may act on alerts; null while unknown

  /** `changed` receives the severity by track; `renewHistory` requests the ended alerts. */
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

  /** Opening the panel moves the focus into it; closing it moves the focus back. */
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

  /** Whether the focus is in the panel. */
  get hasFocus() {
    return this.panel.contains(document.activeElement);
  }

  /** Takes the answer of /alerts; alerts missing in it have ended. */
  replace(answer) {
    const before = this.known;
    this.known = new Map(list(answer, "alerts").map((alert) => [alert.id, alert]));
    // Alerts that existed when the page was loaded are not news.
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

  /** Reports an alert as news if it has begun or become critical. Compares the start too, because a restarted service reuses ids. */
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

  /** Reason why the buttons are disabled; "" if they work. */
  bar() {
    if (this.mayControl === null) return "Whether you may acknowledge and shelve alerts is not known yet.";
    return this.mayControl ? "" : "Your token may only read: to acknowledge and shelve takes one with the scope “control”.";
  }

  /** Alerts that are neither acknowledged nor shelved. */
  waiting() {
    return [...(this.known?.values() ?? [])].filter((alert) => !isQuiet(alert));
  }

  /** Number of these alerts, as text. */
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

  /** Note about information that the list alone does not show. */
  note() {
    const { state, since, why } = this.read ?? { state: "unknown" };
    if (state === "unknown") return "Not known yet";
    if (state === "failed") return `Not known since ${format.utc(since)} UTC (${why}); there may be others than these`;
    return this.known.size ? "" : "None";
  }

  /** The title is the only visible part of a background page: it starts with the count, marked if an alert is critical. */
  showTitle() {
    const { worst } = this.news;
    const mark = this.waiting().some(isCritical) ? "!" : "";
    const count = this.read?.state === "failed" || Number(this.count) ? `(${this.count}${mark}) ` : "";
    const news = worst ? `${worst.text ?? worst.kind} – ` : "";
    const title = `${count}${news}${this.site ? `${this.site} – ` : ""}utm-fusion`;
    if (document.title !== title) document.title = title;
  }
}
