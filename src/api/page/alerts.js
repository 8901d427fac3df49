// The alerts: the worst first, their count always in sight.

import { byId, element, setAttribute, setText } from "./dom.js";
import * as format from "./format.js";
import { change } from "./settings.js";

const RANK = { critical: 0, warning: 1, info: 2 };
const MOST = 200; // shown; the count tells of the rest
const OVER = ["ended", "cleared", "resolved"];

export class Alerts {
  known = new Map();

  /** `changed` is told the severity by track. */
  constructor(changed) {
    this.changed = changed;
    this.panel = byId("alerts");
    this.button = byId("alerts-button");
    this.button.addEventListener("click", () => this.open(this.panel.hidden));
    this.show();
  }

  open(isOpen) {
    this.panel.hidden = !isOpen;
    setAttribute(this.button, "aria-expanded", String(isOpen));
  }

  /** The answer of /alerts: what it does not name is over. */
  replace({ alerts = [] }) {
    this.known = new Map(alerts.map((alert) => [alert.id, alert]));
    this.show();
  }

  update(alert) {
    if (alert.until || OVER.includes(alert.state)) {
      this.known.delete(alert.id);
    } else {
      if (!this.known.has(alert.id) && alert.severity === "critical") this.open(true);
      this.known.set(alert.id, alert);
    }
    this.show();
  }

  show() {
    const sorted = [...this.known.values()].sort(
      (a, b) => (RANK[a.severity] ?? 3) - (RANK[b.severity] ?? 3) || String(b.since).localeCompare(String(a.since)),
    );
    setText(byId("alert-count"), String(sorted.length));
    setAttribute(this.button, "data-severity", sorted[0]?.severity ?? "none");
    const shown = JSON.stringify(sorted);
    if (shown === this.shown) return; // or whoever has a finger or the focus on one would lose it
    this.shown = shown;
    const items = sorted.slice(0, MOST).map((alert) => item(alert));
    if (!items.length) items.push(element("li", { class: "empty" }, "None"));
    byId("alert-list").replaceChildren(...items);
    const byTrack = new Map();
    for (const { track, severity } of sorted) {
      if (track && severity !== "info" && !byTrack.has(track)) byTrack.set(track, severity);
    }
    this.changed(byTrack);
  }
}

function item({ severity, kind, text, since, track }) {
  const head = element("span", { class: "severity" }, `${severity}`);
  const body = element("span", {}, text ?? kind);
  const when = element("small", {}, `${(kind ?? "").replaceAll("_", " ")} · since ${format.utc(Date.parse(since))}`);
  const content = [head, body, when];
  if (!track) return element("li", { "data-severity": severity }, ...content);
  const button = element("button", { type: "button", title: `Select ${track}` }, ...content);
  button.addEventListener("click", () => change({ selected: track }));
  return element("li", { "data-severity": severity }, button);
}
