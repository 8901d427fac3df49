// Members of a cluster: a light beside those of the sensors, and a panel.

import { list } from "./api.js";
import { byId, element, find, setAttribute, setText } from "./dom.js";
import * as format from "./format.js";

/** @type {Record<string, string>} */
const LOOKS = { ok: "●", warning: "▲", critical: "■", unknown: "?" };

export class Cluster {
  /** @type {Members | null} */
  members = null; // last answer of /cluster
  /** @type {Read | null} */
  read = null;
  /** @type {{ text: string, collection: Collection } | null} */
  drawn = null;

  constructor() {
    this.button = byId("cluster");
    this.lamp = find(this.button, ".lamp");
    this.words = find(this.button, ".lamp + span");
    this.panel = byId("cluster-panel");
  }

  /** Shows or hides the light, depending on whether there is a cluster. @param {boolean} isCluster */
  offer(isCluster) {
    this.button.hidden = !isCluster;
  }

  /** Takes the answer of /cluster. @param {Members} members */
  replace(members) {
    list(members, "cells");
    this.members = members;
    this.show();
  }

  /** Outlines of the cells as GeoJSON, each named by itself and its owner. The same object as long as nothing changes. */
  outlines() {
    const cells = this.members?.cells.filter(({ corners }) => corners.length) ?? [];
    const named = cells.map(({ cell, owner, corners }) => ({ name: `${cell}: ${owner ?? "nobody"}`, corners }));
    const text = JSON.stringify(named);
    if (text !== this.drawn?.text) {
      /** @type {GeoJson[]} */
      const features = named.map(({ name, corners }) => ({
        type: "Feature",
        properties: { name },
        geometry: { type: "Polygon", coordinates: [[...corners, corners[0]]] },
      }));
      this.drawn = { text, collection: { type: "FeatureCollection", features } };
    }
    return this.drawn.collection;
  }

  /** Whether the answer is known. @param {Read} read */
  setRead(read) {
    this.read = { ...read };
    this.show();
  }

  show() {
    const [look, text, why] = this.state();
    setAttribute(this.button, "data-look", look);
    setAttribute(this.button, "title", why);
    setAttribute(this.button, "aria-label", `Cluster: ${why}`);
    setText(this.lamp, LOOKS[look]);
    setText(this.words, text);
    this.panel.replaceChildren(...this.describe());
  }

  /** Appearance, text, and description of the light. */
  state() {
    if (this.read?.state === "failed") return ["unknown", "cluster", `not known since ${format.utc(this.read.since)} UTC (${this.read.why})`];
    if (!this.members) return ["unknown", "cluster", "not known yet"];
    const { cells } = this.members;
    const ownerless = cells.filter(({ owner }) => !owner).map(({ cell }) => cell);
    if (ownerless.length) return ["critical", "no owner", `nobody owns ${ownerless.join(", ")}: nothing is published there`];
    const missing = cells.filter(({ is_missing }) => is_missing).map(({ cell }) => cell);
    if (missing.length) return ["critical", "cell missing", `the picture is without ${missing.join(", ")}: nobody publishes what flies there`];
    const foreign = cells.filter(({ is_foreign }) => is_foreign).map(({ cell }) => cell);
    if (foreign.length) return ["critical", "foreign cell", `the picture is without ${foreign.join(", ")}: its owner has another configuration`];
    const alone = cells.filter(({ standby }) => !standby).map(({ cell }) => cell);
    const owners = [...new Set(cells.map(({ owner }) => owner))].join(", ");
    if (alone.length) return ["warning", owners, `${owners}: nobody stands by for ${alone.join(", ")}`];
    const { missing_gateways: silent = [], different = [] } = this.members;
    if (different.length) return ["critical", owners, different.map((of) => `another configuration: ${of}`).join("\n")];
    if (silent.length) return ["warning", owners, `gateway ${silent.join(", ")} says nothing`];
    const doubts = clockDoubts(this.members);
    if (doubts.length) return ["warning", owners, doubts.join("\n")];
    return ["ok", owners, cells.map(({ cell, owner, standby }) => `${cell}: ${owner} owns it, ${standby} stands by`).join("\n")];
  }

  describe() {
    if (!this.members) return [element("h2", {}, "Cluster"), element("p", {}, "Not known yet")];
    const { region, cells, nodes, gateways, clocks, shown, doubled, missing, twice, too_late: late, missing_gateways: silent = [], different = [] } = this.members;
    return [
      element("h2", {}, `Cluster ${region}`),
      table(["Cell", "Owner", "Standby", "Lease", "Behind"], cells.map((of) => [of.cell, of.owner ?? "nobody", of.standby ?? "nobody", of.lease, of.behind])),
      table(
        ["Node", "Machine", "Is", "Owns", "Stands by", "Take-overs", "Refused"],
        nodes.map((of) => [of.node, of.machine, of.part, of.owns.length, of.stands_by.length, of.takeovers, of.fenced]),
      ),
      table(["Gateway", "Lines", "Written", "Waiting", "Dropped", "Clock"], gateways.map((of) => [of.node, of.lines, of.written, of.waiting, of.dropped, clock(of)])),
      ...silent.map((gateway) => element("p", { class: "doubt" }, `Gateway ${gateway} says nothing`)),
      ...different.map((of) => element("p", { class: "doubt" }, `Another configuration: ${of}`)),
      ...clocks.map((of) => element("p", { class: of.apart ? "doubt" : "hint" }, `${of.gateway} stamps ${milliseconds(Math.abs(of.difference_s))} ${of.difference_s < 0 ? "earlier" : "later"} than ${of.other}`)),
      element("p", { class: "hint" }, `${shown} slots shown, ${missing} missing, ${doubled} twice`),
      ...(cells.length > 1 ? [element("p", { class: "hint" }, `${twice} aircraft published by two cells, ${late} slots of cells too late`)] : []),
    ];
  }
}

/** @param {number} seconds */
const milliseconds = (seconds) => `${(seconds * 1000).toFixed(Math.abs(seconds) < 0.01 ? 1 : 0)} ms`;

const CLOCKS = { good: "", warning: "▲", degraded: "▲ degraded", unbounded: "synchronised, how well is not known", unsynchronised: "▲ not synchronised", unknown: "not known" };

/** Text about a gateway's clock. @param {GatewayState} gateway */
function clock({ clock: standing, clock_bound_s: bound, silent }) {
  return [bound === undefined ? "" : `±${milliseconds(bound)}`, CLOCKS[standing] ?? standing, silent ? "silent" : ""].filter(Boolean).join(" ");
}

/** Doubts about the clocks of gateways. An unknown clock is not in doubt. @param {Members} members */
function clockDoubts({ gateways, clocks }) {
  const doubted = gateways.filter(({ clock: standing }) => !["good", "unbounded", "unknown"].includes(standing));
  const apart = clocks.filter((of) => of.apart);
  return [
    ...doubted.map((of) => `clock of ${of.node}: ${clock(of)}`),
    ...apart.map((of) => `clocks of ${of.gateway} and ${of.other} differ by ${milliseconds(Math.abs(of.difference_s))}`),
  ];
}

/** @param {string[]} names @param {(string | number)[][]} rows */
function table(names, rows) {
  /** @param {(string | number)[]} cells @param {"th" | "td"} kind */
  const row = (cells, kind) => element("tr", {}, ...cells.map((cell) => element(kind, {}, String(cell))));
  return element("table", { class: "lines" }, element("thead", {}, row(names, "th")), element("tbody", {}, ...rows.map((cells) => row(cells, "td"))));
}
