// The alerts that are over: by kind and time, the latest first, and more of them on demand.

import { get, list } from "./api.js";
import { headOf, whoOf } from "./alertitem.js";
import { byId, element, setText } from "./dom.js";
import * as format from "./format.js";

const PAGE = 50;
const MOST = 5000; // the service's
const KINDS = ["area", "area-predicted", "conflict", "integrity", "jamming", "silent", "uncooperative", "emergency", "sensor", "registration", "service"];

export class AlertHistory {
  limit = PAGE;

  /** `renew` asks anew. */
  constructor(renew) {
    this.panel = byId("alert-history");
    this.kind = byId("history-kind");
    this.kind.append(...KINDS.map((kind) => element("option", { value: kind }, kind.replaceAll("-", " "))));
    const again = () => {
      this.limit = PAGE;
      renew();
    };
    this.panel.addEventListener("toggle", again);
    for (const id of ["history-kind", "history-since", "history-until"]) byId(id).addEventListener("change", again);
    byId("history-more").addEventListener("click", () => {
      this.limit = Math.min(MOST, this.limit + PAGE);
      renew();
    });
  }

  get isWanted() {
    return this.panel.open && !byId("alerts").hidden;
  }

  ask() {
    const query = new URLSearchParams({ limit: this.limit });
    if (this.kind.value) query.set("kind", this.kind.value);
    const [since, until] = ["since", "until"].map((name) => byId(`history-${name}`).value);
    const isBackwards = since && until && until < since;
    if (since) query.set("since", utc(since));
    if (until && !isBackwards) query.set("until", utc(until));
    setText(byId("history-fault"), isBackwards ? "“To” is before “from”: it is left out." : "");
    return get(`alerts?${query}`);
  }

  take(answer) {
    const ended = list(answer, "ended");
    byId("history-more").hidden = !answer.more || ended.length >= MOST;
    const shown = JSON.stringify(ended);
    if (shown === this.shown) return;
    this.shown = shown;
    const items = ended.map((alert) => row(alert));
    if (!items.length) items.push(element("li", { class: "empty" }, "None that is remembered"));
    byId("history-list").replaceChildren(...items);
  }
}

/** Of a field for a time in UTC, which leaves out the seconds where there are none. */
const utc = (text) => `${text.length === 16 ? `${text}:00` : text}Z`;

function row(alert) {
  const { kind, severity, since, until } = alert;
  const [from, to] = [Date.parse(since), Date.parse(until)];
  const when = `${kind.replaceAll("-", " ")} · ${format.date(from)} ${format.utc(from)} to ${format.utc(to)} (${format.duration((to - from) / 1000)})`;
  const who = whoOf(alert);
  return element("li", { "data-severity": severity }, element("p", {}, ...headOf(alert)), element("small", {}, when), who ? element("small", { class: "who" }, who) : null);
}
