// The attention list: active alerts, ended ones that wait for an acknowledgement, and their number.

import { askForAnother, hasToken, list } from "./api.js";
import { severityOf, tracksOf } from "./alertitem.js";
import { AlertHistory } from "./alerthistory.js";
import { AlertList, sorted } from "./alertlist.js";
import { byId, setAttribute, setText } from "./dom.js";
import * as format from "./format.js";
import { News } from "./news.js";
import { Sound } from "./sound.js";

/** @param {Alert} alert */
const isCritical = (alert) => severityOf(alert) === "critical";
/** @param {Alert} alert */
const isQuiet = ({ acknowledged, shelved }) => Boolean(acknowledged ?? shelved);

const SMALL = "(max-width: 600px), (max-height: 480px)"; // as in the style sheet

export class Alerts {
  /** @type {Map<string, Alert> | null} */
  known = null; // active ones by id; null until the first answer or event
  /** @type {Map<string, Alert>} */
  latched = new Map(); // ended ones that wait for an acknowledgement, by id
  /** @type {Read | null} */
  read = null; // whether the known alerts are complete
  site = "";
  /** @type {boolean | null} */
  mayControl = null; // whether the user may act on alerts; null while unknown

  /**
   * `changed` receives the severity by track, and the tracks of each conflict that has an alert; `renewHistory` requests the ended
   * alerts; `go(ids)` shows these tracks on the map.
   * @param {{
   *   changed: (byTrack: Map<string, Severity>, conflicts: Set<string>[]) => void,
   *   renewHistory: () => void,
   *   go: (ids: string[]) => void,
   * }} callbacks
   */
  constructor({ changed, renewHistory, go }) {
    this.changed = changed;
    this.renewHistory = renewHistory;
    this.panel = byId("alerts");
    this.panel.hidden = matchMedia(SMALL).matches;
    this.button = byId("alerts-button");
    this.button.addEventListener("click", () => this.toggle());
    byId("alerts-close").addEventListener("click", () => this.toggle());
    byId("alert-bar-token").addEventListener("click", askForAnother);
    this.history = new AlertHistory(renewHistory);
    this.list = new AlertList({ bar: () => this.bar(), took: (alert) => this.update(alert), hasToken, go });
    this.sound = new Sound(() => this.waiting().some(isCritical));
    this.news = new News({
      open: () => this.open(true),
      changed: () => this.showTitle(),
      told: (alert) => this.sound.note(alert),
      acknowledge: (alert) => this.list.act(alert, "acknowledge", {}),
    });
    setAttribute(this.button, "aria-expanded", String(!this.panel.hidden));
    this.show();
  }

  /** Opening the panel moves the focus into it; closing it moves the focus back. @param {boolean} isOpen */
  open(isOpen) {
    this.panel.hidden = !isOpen;
    setAttribute(this.button, "aria-expanded", String(isOpen));
    if (isOpen) {
      this.news.seen();
      this.cameFrom = document.activeElement;
      this.panel.focus();
    } else if (this.cameFrom instanceof HTMLElement && this.cameFrom.isConnected) {
      this.cameFrom.focus();
    }
    this.renewHistory();
  }

  toggle() {
    this.open(Boolean(this.panel.hidden));
  }

  /** Whether the focus is in the panel. */
  get hasFocus() {
    return this.panel.contains(document.activeElement);
  }

  /** Takes the answer of /alerts; alerts missing in it have ended. @param {AlertsAnswer} answer */
  replace(answer) {
    const before = this.known;
    this.latched = new Map(list(answer, "latched").map((alert) => [alert.id, alert]));
    this.known = new Map(list(answer, "alerts").map((alert) => [alert.id, alert]));
    // Alerts that existed when the page was loaded are not news.
    for (const alert of this.known.values()) if (before) this.compare(before.get(alert.id), alert);
    for (const alert of before?.values() ?? []) if (!this.known.has(alert.id)) this.news.over(alert);
    this.show();
  }

  /** @param {Alert} alert */
  update(alert) {
    this.known ??= new Map();
    if (alert.until) {
      this.known.delete(alert.id);
      if (alert.latched) this.latched.set(alert.id, alert);
      else this.latched.delete(alert.id);
      if (alert.acknowledged) this.news.settle(alert);
      else this.news.over(alert);
      this.renewHistory();
    } else {
      this.compare(this.known.get(alert.id), alert);
      this.known.set(alert.id, alert);
    }
    this.show();
  }

  /**
   * Reports an alert as news if it has begun or become critical. Compares the start too, because a restarted service reuses ids.
   * @param {Alert | undefined} before @param {Alert} alert
   */
  compare(before, alert) {
    if (isQuiet(alert)) return this.news.settle(alert);
    const isWorse = isCritical(alert) && !isCritical(before ?? alert);
    if (before?.since !== alert.since || isWorse || isQuiet(before)) this.news.note(alert, !this.panel.hidden);
  }

  /** Whether the answer of /alerts is known. @param {Read} read */
  setRead(read) {
    this.read = read;
    this.show();
  }

  /** @param {boolean} mayControl */
  setControl(mayControl) {
    this.mayControl = mayControl;
    this.show();
  }

  /** Reason why the buttons are disabled; "" if they work. */
  bar() {
    if (this.mayControl === null) return "Whether you may acknowledge and shelve alerts is not known yet.";
    return this.mayControl ? "" : "Your token may only read: to acknowledge and shelve takes one with the scope “control”.";
  }

  /** All of the list. An alert that lasts is no latched one, also if an id was used again after a restart. */
  all() {
    const { known, latched } = this;
    return sorted([...(known?.values() ?? []), ...[...latched.values()].filter(({ id }) => !known?.has(id))]);
  }

  /** Those that are neither acknowledged nor shelved. */
  waiting() {
    return this.all().filter((alert) => !isQuiet(alert));
  }

  /** Number of these alerts, as text. */
  get count() {
    return this.read?.state === "good" ? String(this.waiting().length) : "?";
  }

  show() {
    const all = this.all();
    const worst = this.waiting()[0];
    setText(byId("alert-count"), this.count);
    setAttribute(this.button, "data-severity", worst ? severityOf(worst) : "none");
    setText(byId("alert-words"), this.read?.state === "good" && all.length ? `${all.length} (${this.count} not acknowledged)` : "");
    this.showTitle();
    setText(byId("alert-note"), this.note());
    this.list.show(all);
    const byTrack = new Map();
    const active = all.filter(({ until }) => !until);
    for (const alert of active.filter(({ shelved }) => !shelved)) {
      for (const track of tracksOf(alert)) if (!byTrack.has(track)) byTrack.set(track, alert.severity);
    }
    this.changed(byTrack, active.filter(({ kind }) => kind === "conflict").map((alert) => new Set(tracksOf(alert))));
  }

  /** Note about information that the list alone does not show. */
  note() {
    const { state, since, why } = this.read ?? { state: "unknown", since: NaN, why: "" };
    if (state === "unknown") return "Not known yet";
    if (state === "failed") return `Not known since ${format.utc(since)} UTC (${why}); there may be others than these`;
    return (this.known?.size ?? 0) + this.latched.size ? "" : "Nothing needs attention";
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
