// List of situations. Items do not move under a finger or pointer, and the focused one keeps the focus.

import { post } from "./api.js";
import { AlertItem, severityOf } from "./alertitem.js";
import { byId, element, setText } from "./dom.js";

const MOST = 200; // maximum shown; a count covers the rest
const STILL_MS = 1000; // time after a pointer movement over the list during which items stay in place
const NAME = "utm-fusion-name";

const rank = (alert) => ({ critical: 0, warning: 1 })[severityOf(alert)] ?? 2;
const latest = (a, b) => String(b.since).localeCompare(String(a.since));
const urgent = (a, b) => rank(a) - rank(b) || Boolean(a.acknowledged) - Boolean(b.acknowledged) || Boolean(a.until) - Boolean(b.until) || latest(a, b);

/** Most urgent first. */
export const sorted = (alerts) => [...alerts].sort(urgent);

export class AlertList {
  items = new Map(); // by alert id
  movedAt = -Infinity; // time of the last pointer movement over the list, on the page's monotonic clock
  timer = null;

  /**
   * `bar()`: reason why the user may not act, or ""; `took` receives the alert in an answer; `hasToken()`: whether a token
   * identifies the user; `go(ids)` shows these tracks on the map.
   */
  constructor({ bar, took, hasToken, go }) {
    Object.assign(this, { bar, took, hasToken, go });
    this.name = byId("alert-by");
    this.name.value = localStorage.getItem(NAME) ?? "";
    this.name.addEventListener("change", () => localStorage.setItem(NAME, this.name.value.trim()));
    for (const type of ["pointermove", "pointerdown"]) {
      byId("alerts").addEventListener(type, () => { this.movedAt = performance.now(); }, { passive: true });
    }
  }

  show(alerts) {
    this.alerts = alerts;
    const bar = this.bar();
    byId("alert-bar").hidden = !bar;
    setText(byId("alert-bar-words"), bar);
    this.name.closest("label").hidden = Boolean(bar) || this.hasToken();
    const shelved = alerts.filter((alert) => alert.shelved).sort((a, b) => a.shelved.until.localeCompare(b.shelved.until));
    byId("alert-shelved").hidden = !shelved.length;
    setText(byId("shelved-count"), String(shelved.length));
    this.places = [["alert-list", sorted(alerts.filter((alert) => !alert.shelved))], ["shelved-list", shelved]];
    for (const [, chosen] of this.places) {
      for (const alert of chosen.slice(0, MOST)) {
        if (!this.items.has(alert.id)) this.items.set(alert.id, new AlertItem((...wish) => this.act(...wish), this.go));
        this.items.get(alert.id).update(alert, Boolean(bar));
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
      const nodes = chosen.slice(0, MOST).map((alert) => this.items.get(alert.id).node);
      if (chosen.length > MOST) nodes.push(element("li", {}, `and ${chosen.length - MOST} more`));
      const list = byId(id);
      const isSame = nodes.length === list.children.length && nodes.every((node, at) => node === list.children[at]);
      if (!isSame) list.replaceChildren(...nodes);
    }
    if (focused !== document.activeElement && focused.isConnected) focused.focus({ preventScroll: true });
  }

  /** Requests an action from the service. Returns whether it was done. */
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

  say(words) {
    setText(byId("alert-said"), words);
    return false;
  }
}
