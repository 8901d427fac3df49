// Ended alerts: by kind and time, latest first, with more on demand.

import { get, list } from "./api.js";
import { headOf, whoOf } from "./alertitem.js";
import { byId, element, setText } from "./dom.js";
import * as format from "./format.js";

const PAGE = 50;
const MOST = 5000; // the service's limit
const KINDS = ["area", "area-predicted", "conflict", "integrity", "jamming", "silent", "height", "uncooperative", "emergency", "sensor", "registration", "service"];

export class AlertHistory {
  limit = PAGE;
  shown = ""; // data from which the list was made

  /** `renew` requests the alerts again. @param {() => void} renew */
  constructor(renew) {
    this.panel = byId("alert-history", HTMLDetailsElement);
    this.kind = byId("history-kind", HTMLSelectElement);
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
    const query = new URLSearchParams({ limit: String(this.limit) });
    if (this.kind.value) query.set("kind", this.kind.value);
    const texts = ["since", "until"].map((name) => byId(`history-${name}`, HTMLInputElement).value.trim());
    const [since, until] = texts.map(utc);
    const isBackwards = since && until && until < since;
    if (since) query.set("since", since);
    if (until && !isBackwards) query.set("until", until);
    const isWrong = texts.some((text) => text && !utc(text));
    const fault = isWrong ? "Not a time: write 2026-03-14 09:01:20 (UTC). It is left out." : isBackwards ? "“To” is before “from”: it is left out." : "";
    setText(byId("history-fault"), fault);
    return get(`alerts?${query.toString()}`);
  }

  /** @param {AlertsAnswer} answer */
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

/** UTC time in ISO form from a date, or a date and a time, as typed; "" if it is neither. @param {string} text */
function utc(text) {
  const [, date, minute = "00:00", second = ":00"] = /^(\d{4}-\d\d-\d\d)(?:[T ](\d\d:\d\d)(:\d\d)?)?Z?$/.exec(text) ?? [];
  const time = `${date}T${minute}${second}Z`;
  return Number.isFinite(Date.parse(time)) ? time : "";
}

/** @param {Alert} alert */
function row(alert) {
  const { kind, severity, since, until } = alert;
  const [from, to] = [Date.parse(since), Date.parse(until)];
  const when = `${kind.replaceAll("-", " ")} · ${format.date(from)} ${format.utc(from)} to ${format.utc(to)} (${format.duration((to - from) / 1000)})`;
  const who = whoOf(alert);
  return element("li", { "data-severity": severity }, element("p", {}, ...headOf(alert)), element("small", {}, when), who ? element("small", { class: "who" }, who) : null);
}
