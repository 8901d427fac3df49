// List of situations. Items do not move under a finger or pointer, and the focused one keeps the focus.

import { post } from "./api.js";
import { AlertItem, severityOf } from "./alertitem.js";
import { byId, element, find, setText } from "./dom.js";

const MOST = 200; // maximum shown; a count covers the rest
const STILL_MS = 1000; // time after a pointer movement over the list during which items stay in place
const NAME = "utm-fusion-name";

/** @param {Alert} alert */
const rank = (alert) => ({ critical: 0, warning: 1 })[severityOf(alert)] ?? 2;
/** @param {Alert} a @param {Alert} b */
const latest = (a, b) => String(b.since).localeCompare(String(a.since));
/** @param {Alert} a @param {Alert} b */
const urgent = (a, b) => rank(a) - rank(b) || Number(isSeen(a)) - Number(isSeen(b)) || Number(isOver(a)) - Number(isOver(b)) || latest(a, b);

/** @param {Alert} alert */
const isSeen = ({ acknowledged }) => Boolean(acknowledged);
/** @param {Alert} alert */
const isOver = ({ until }) => Boolean(until);

/** End of the shelving. @param {Alert} alert */
const endOf = ({ shelved }) => shelved?.until ?? "";

/** Most urgent first. @param {Alert[]} alerts */
export const sorted = (alerts) => [...alerts].sort(urgent);

export class AlertList {
  /** @type {Map<string, AlertItem>} */
  items = new Map(); // by alert id
  /** @type {Alert[]} */
  alerts = [];
  /** @type {[string, Alert[]][]} */
  places = []; // id of each list, and its alerts in order
  movedAt = -Infinity; // time of the last pointer movement over the list, on the page's monotonic clock
  /** @type {number | undefined} */
  timer;

  /**
   * `bar()`: reason why the user may not act, or ""; `took` receives the alert in an answer; `hasToken()`: whether a token
   * identifies the user; `go(ids)` shows these tracks on the map.
   * @param {{ bar: () => string, took: (alert: Alert) => void, hasToken: () => boolean, go: (ids: string[]) => void }} callbacks
   */
  constructor({ bar, took, hasToken, go }) {
    this.bar = bar;
    this.took = took;
    this.hasToken = hasToken;
    this.go = go;
    this.name = byId("alert-by", HTMLInputElement);
    this.label = find(byId("alerts"), ".alert-by");
    this.name.value = localStorage.getItem(NAME) ?? "";
    this.name.addEventListener("change", () => localStorage.setItem(NAME, this.name.value.trim()));
    for (const type of ["pointermove", "pointerdown"]) {
      byId("alerts").addEventListener(type, () => { this.movedAt = performance.now(); }, { passive: true });
    }
  }

  /** @param {Alert[]} alerts */
  show(alerts) {
    this.alerts = alerts;
    const bar = this.bar();
    byId("alert-bar").hidden = !bar;
    setText(byId("alert-bar-words"), bar);
    this.label.hidden = Boolean(bar) || this.hasToken();
    const shelved = alerts.filter((alert) => alert.shelved).sort((a, b) => endOf(a).localeCompare(endOf(b)));
    byId("alert-shelved").hidden = !shelved.length;
    setText(byId("shelved-count"), String(shelved.length));
    this.places = [["alert-list", sorted(alerts.filter((alert) => !alert.shelved))], ["shelved-list", shelved]];
    for (const [, chosen] of this.places) {
      for (const alert of chosen.slice(0, MOST)) {
        let item = this.items.get(alert.id);
        if (!item) this.items.set(alert.id, (item = new AlertItem(alert, (...wish) => this.act(...wish), this.go)));
        item.update(alert, Boolean(bar));
      }
    }
    this.arrange();
  }

  /** Sorts now, or as soon as the pointer rests: otherwise a click could hit another alert. */
  arrange() {
    clearTimeout(this.timer);
    const wait = this.movedAt + STILL_MS - performance.now();
    if (wait > 0) {
      this.timer = setTimeout(() => this.arrange(), wait);
      return;
    }
    const ids = new Set(this.alerts.map(({ id }) => id));
    for (const id of this.items.keys()) if (!ids.has(id)) this.items.delete(id);
    const focused = document.activeElement;
    for (const [id, chosen] of this.places) {
      const nodes = chosen.slice(0, MOST).flatMap((alert) => this.items.get(alert.id)?.node ?? []);
      if (chosen.length > MOST) nodes.push(element("li", {}, `and ${chosen.length - MOST} more`));
      const list = byId(id);
      const isSame = nodes.length === list.children.length && nodes.every((node, at) => node === list.children[at]);
      if (!isSame) list.replaceChildren(...nodes);
    }
    if (focused === document.activeElement || !(focused instanceof HTMLElement)) return;
    if (focused.isConnected) focused.focus({ preventScroll: true });
  }

  /**
   * Requests an action from the service. Returns whether it was done.
   * @param {Alert} alert @param {AlertAction} what @param {object} body
   */
  async act(alert, what, body) {
    const bar = this.bar();
    if (bar) return this.say(bar);
    const by = this.hasToken() ? "" : this.name.value.trim(); // otherwise the token identifies the user
    try {
      this.movedAt = -Infinity; // the clicked item may move
      this.took(await post(`alerts/${encodeURIComponent(alert.id)}/${what}`, {}, by ? { ...body, by } : body));
    } catch (error) {
      return this.say(`${what}: ${error.message}`);
    }
    this.say("");
    return true;
  }

  /** @param {string} words */
  say(words) {
    setText(byId("alert-said"), words);
    return false;
  }
}
