// New alerts while their panel is closed: announced once to screen readers, shown on the map until seen, and counted in the
// title.

import { headOf } from "./alertitem.js";
import { byId, element, setText } from "./dom.js";
import * as format from "./format.js";

const AGAIN_MS = 60000; // a recurring alert is new again after this time, or when it is more severe
const APART_MS = 5000; // time between two announcements, enough for a screen reader to finish one
const OVER_MS = 60000; // an ended warning stays visible for this time; a critical alert stays
const SHOWN = 3;

/** Subject of an alert. An alert that ends and begins again has another id and the same subject. @param {Alert} alert */
const about = ({ kind, sensor, track, part, identity, conflict, area }) =>
  [kind, sensor ?? track ?? part ?? identity ?? conflict, area?.identifier ?? area?.name].join(" ");
/** @param {Alert} alert */
const rank = ({ severity }) => ({ critical: 2, warning: 1 })[severity] ?? 0;

/** An alert, and the time of its end, in ms since 1970. @typedef {{ alert: Alert, over: number | null }} Unseen */

export class News {
  /** @type {Map<string, Unseen>} */
  unseen = new Map(); // by subject
  /** @type {Map<string, [number, number]>} */
  told = new Map(); // time and rank by subject, on the page's monotonic clock
  /** @type {Alert[]} */
  unsaid = []; // alerts to announce
  saidAt = -Infinity;

  /**
   * `open` shows the panel; `changed` is called when the news change; `told` receives each new alert; `acknowledge` acknowledges
   * one, and opens nothing.
   * @param {{
   *   open: () => void, changed: () => void, told: (alert: Alert) => void, acknowledge: (alert: Alert) => Promise<boolean>,
   * }} callbacks
   */
  constructor({ open, changed, told, acknowledge }) {
    this.changed = changed;
    this.tell = told;
    byId("toast-open").addEventListener("click", open);
    // If it fails, the panel says why.
    byId("toast-acknowledge").addEventListener("click", async () => {
      const { worst } = this;
      if (worst && !(await acknowledge(worst))) open();
    });
    byId("toast-close").addEventListener("click", () => this.seen());
    setInterval(() => this.tick(), 1000);
  }

  /**
   * Takes an alert that has begun or become more severe; `isSeen`: it is visible anyway.
   * @param {Alert} alert @param {boolean} isSeen
   */
  note(alert, isSeen) {
    const [key, now] = [about(alert), performance.now()];
    const [at, before] = this.told.get(key) ?? [-Infinity, -1];
    const known = this.unseen.get(key);
    if (known) this.unseen.set(key, { alert, over: null });
    if (now - at < AGAIN_MS && rank(alert) <= before) return known && this.show();
    this.told.set(key, [now, rank(alert)]);
    this.unsaid.push(alert);
    this.tell(alert);
    if (!isSeen) this.unseen.set(key, { alert, over: null });
    this.show();
    this.say();
  }

  /** Takes an alert that has ended. @param {Alert} alert */
  over(alert) {
    const known = this.unseen.get(about(alert));
    if (!known || known.over) return;
    known.over = Date.now();
    this.show();
  }

  /** Takes an alert that was acknowledged or shelved, on this page or another. @param {Alert} alert */
  settle(alert) {
    this.unsaid = this.unsaid.filter(({ id }) => id !== alert.id);
    if (this.unseen.delete(about(alert))) this.show();
  }

  seen() {
    this.unseen.clear();
    this.show();
  }

  /** Most severe unseen alert, latest first; null if there is none. */
  get worst() {
    return this.sorted()[0]?.alert ?? null;
  }

  sorted() {
    /** @param {Unseen} news */
    const bad = ({ alert, over }) => rank(alert) - (over ? 3 : 0);
    return [...this.unseen.values()].reverse().sort((a, b) => bad(b) - bad(a));
  }

  show() {
    const sorted = this.sorted();
    const lines = sorted.slice(0, SHOWN).map(({ alert, over }) => {
      const ended = over ? ` (over at ${format.utc(over)} UTC)` : "";
      return element("li", { "data-severity": alert.severity }, ...headOf(alert), ended);
    });
    const more = sorted.length - lines.length;
    if (more) lines.push(element("li", {}, `and ${more} more`));
    setText(byId("toast-open"), sorted.length > 1 ? `Show all ${sorted.length}` : "Show alerts");
    byId("toast").hidden = lines.length === 0;
    byId("toast-list").replaceChildren(...lines);
    this.changed();
  }

  /** Announces at once, or soon after the last announcement together with later news. */
  say() {
    if (!this.unsaid.length || performance.now() - this.saidAt < APART_MS) return;
    const worst = this.unsaid.reduce((one, other) => (rank(other) > rank(one) ? other : one));
    const others = this.unsaid.length > 1 ? `, and ${this.unsaid.length - 1} more` : "";
    setText(byId("alert-announcement"), `New alert, ${worst.severity}: ${worst.text ?? worst.kind}${others}`);
    this.unsaid = [];
    this.saidAt = performance.now();
  }

  tick() {
    this.say();
    const now = performance.now();
    for (const [key, [at]] of this.told) if (now - at > AGAIN_MS) this.told.delete(key);
    const { size } = this.unseen;
    for (const [key, { alert, over }] of this.unseen) {
      if (over && alert.severity !== "critical" && Date.now() - over > OVER_MS) this.unseen.delete(key);
    }
    if (this.unseen.size !== size) this.show();
  }
}
