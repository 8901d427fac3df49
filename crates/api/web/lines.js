// Inputs of a sensor as a table: address, state, rate, and unused datagrams.

import { element } from "./dom.js";
import * as format from "./format.js";

/** Counters of received datagrams that were not used. */
/** @type {("foreign" | "duplicates" | "queue_full" | "kernel_dropped")[]} */
const REFUSED = ["foreign", "duplicates", "queue_full", "kernel_dropped"];

export class LineRates {
  before = new Map(); // {time, received} by sensor and line
  rates = new Map(); // datagrams per second, by sensor and line

  /**
   * Takes the sensors at a time, in ms since 1970. Rates are computed between two answers.
   * @param {number} time @param {Iterable<SensorProperties>} sensors
   */
  note(time, sensors) {
    for (const { id, lines } of sensors) {
      for (const { name, received } of lines ?? []) {
        const key = `${id} ${name}`;
        const before = this.before.get(key);
        const seconds = (time - before?.time) / 1000;
        if (seconds > 0) this.rates.set(key, Math.max(0, received - before.received) / seconds);
        this.before.set(key, { time, received });
      }
    }
  }

  /** @param {SensorProperties} sensor */
  table({ id, lines = [] }) {
    const head = ["Address", "State", "a second", "Refused"].map((text) => element("th", { scope: "col" }, text));
    const body = element("tbody");
    for (const line of lines) {
      const refused = REFUSED.filter((name) => line[name] > 0);
      const rate = this.rates.get(`${id} ${line.name}`);
      const total = refused.reduce((sum, name) => sum + line[name], 0);
      const cells = [line.name, state(line), Number.isFinite(rate) ? rate.toFixed(1) : "–", String(total)];
      body.append(element("tr", {}, ...cells.map((text) => element("td", {}, text))));
      if (refused.length) {
        const why = refused.map((name) => `${format.heading(name).toLowerCase()} ${line[name]}`).join(", ");
        body.append(element("tr", { class: "why" }, element("td", { colspan: cells.length }, why)));
      }
    }
    return element("table", { class: "lines" }, element("thead", {}, element("tr", {}, ...head)), body);
  }
}

/** @param {Line} line */
function state({ joined, last_received }) {
  if (!joined) return "not open";
  return last_received ? `open, last ${format.utc(Date.parse(last_received))}` : "open, nothing yet";
}
