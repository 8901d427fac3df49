// Operator controls: keys, buttons and panels, and the display of the choices.

import { onUnauthorized, setToken } from "./api.js";
import { listenForChoices, showChoices } from "./choices.js";
import { byId, setAttribute, setText } from "./dom.js";
import { FilterPanel } from "./filterpanel.js";
import * as format from "./format.js";
import { bearing } from "./geo.js";
import { Keyboard } from "./keyboard.js";
import { exportPicture, exportTracks } from "./exports.js";
import { showLegend } from "./legend.js";
import { listenForOverlays } from "./overlays.js";
import { applyTheme, nextTheme } from "./palette.js";
import { listenForPrint } from "./print.js";
import { change, onChange, read, settings, toggled, toggleLayer } from "./settings.js";
import { Tools } from "./tools.js";
import { distance } from "./units.js";

const VIEW = ["centre", "scale"]; // settings changed by a pan or zoom, shown by the map only
const NOTE_MS = 1000;
/** @type {Record<string, Point>} */
const PANS = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/**
 * @typedef {{
 *   map: Map2d, status: Status, replay: Replay, alerts: Alerts, activeZones: ActiveZones, reads: Reads,
 *   isPictureKnown: () => boolean,
 * }} Components
 */

export class Operator {
  /** Components controlled by keys and buttons. @param {Components} components */
  constructor({ map, status, replay, alerts, activeZones, reads, isPictureKnown }) {
    this.map = map;
    this.status = status;
    this.replay = replay;
    this.alerts = alerts;
    this.reads = reads;
    this.isPictureKnown = isPictureKnown;
    this.filter = new FilterPanel();
    this.tools = new Tools(map, activeZones);
    listenForChoices();
    listenForOverlays(map);
    listenForPrint(map, () => `${byId("site").textContent}, ${byId("badge").textContent}, ${byId("utc").textContent} ${byId("picture-time").textContent}`);
    this.listenToButtons();
    this.listenToPage();
    this.listenToKeys();
    this.askForToken();
    map.hovered = (px, py) => this.showCursor(px, py);
    onChange((patch) => this.changed(patch));
    setInterval(() => this.note(), NOTE_MS);
  }

  /** @param {Partial<Settings>} patch */
  changed(patch) {
    if (Object.keys(patch).every((name) => VIEW.includes(name))) return;
    if ("theme" in patch) applyTheme();
    if ("theme" in patch || "colourBy" in patch) this.map.repaint();
    this.show();
    this.map.invalidate();
  }

  show() {
    this.filter.show();
    showChoices();
    showLegend();
    setAttribute(byId("follow"), "aria-pressed", String(settings.follow && Boolean(settings.selected)));
    setText(byId("theme-name"), settings.theme);
    this.note();
  }

  note() {
    const { picture } = this.map;
    this.filter.showZones();
    this.filter.note(picture?.visible().length ?? 0, picture && this.isPictureKnown() ? picture.tracks.size : "?");
  }

  listenToButtons() {
    const { map } = this;
    /** @type {Record<string, () => void>} */
    const acts = {
      "zoom-in": () => map.zoom(1.5),
      "zoom-out": () => map.zoom(1 / 1.5),
      fit: () => map.fit(),
      follow: () => this.toggleFollow(),
      "theme-button": () => change({ theme: nextTheme() }),
      "more-button": () => this.openMenu(byId("more-button").getAttribute("aria-expanded") !== "true"),
      "help-button": () => byId("help", HTMLDialogElement).showModal(),
      "sheet-button": () => this.openSheet(byId("sheet-button").getAttribute("aria-expanded") !== "true"),
      "export-png": () => map.picture && exportPicture(map.picture, map.canvas),
      "print-button": () => print(),
    };
    byId("legend").addEventListener("toggle", showLegend); // options may have become available since
    for (const format of /** @type {const} */ (["geojson", "kml", "csv"])) {
      acts[`export-${format}`] = () => map.picture && exportTracks(map.picture, format);
    }
    for (const [id, act] of Object.entries(acts)) byId(id).addEventListener("click", act);
  }

  listenToPage() {
    addEventListener("hashchange", () => {
      read();
      this.map.framed = false;
      this.map.frameOnce();
    });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      applyTheme();
      this.map.repaint();
    });
  }

  listenToKeys() {
    const { map, alerts } = this;
    new Keyboard([
      [["+", "="], "Zoom in", () => map.zoom(1.5)],
      [["-", "_"], "Zoom out", () => map.zoom(1 / 1.5)],
      [["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"], "Pan the map; in the table, select", ({ key }) => {
        const [dx, dy] = PANS[key];
        map.pan(dx, dy);
      }],
      [["0"], "Show all tracks", () => map.fit()],
      [["f"], "Follow the selected track", () => this.toggleFollow()],
      [["m"], "Measure", () => this.tools.toggleMeasure()],
      [["w"], "Watch the selected track, or no longer", () => this.toggleWatch()],
      [["/"], "Filter", () => byId("filter-input").focus()],
      [["n"], "Now: where each is predicted to be", () => this.toggleNow()],
      [["l"], "Labels", () => toggleLayer("labels")],
      [["r"], "Range rings and bearings", () => toggleLayer("rings")],
      [["v"], "Where each will be in 10 s", () => toggleLayer("vectors")],
      [["e"], "Uncertainty of each track", () => toggleLayer("ellipses")],
      [["h"], "Colour by height, or by source", () => change({ colourBy: settings.colourBy === "height" ? "source" : "height" })],
      [["a"], "Alerts", () => alerts.toggle()],
      [["t"], "Theme: auto, light, dark", () => change({ theme: nextTheme() })],
      [[" "], "Replay: play or pause", () => this.status.isReplay && this.replay.toggle()],
      [["?"], "This help", () => byId("help", HTMLDialogElement).showModal()],
      [["Escape"], "Close, or select nothing", () => this.escape()],
    ]);
  }

  askForToken() {
    onUnauthorized(() => {
      if (!byId("sign-in", HTMLDialogElement).open) byId("sign-in", HTMLDialogElement).showModal();
    });
    byId("sign-in-form").addEventListener("submit", () => {
      setToken(byId("token", HTMLInputElement).value);
      byId("token", HTMLInputElement).value = "";
      this.reads.renew("info", "state", "sensors", "alerts", "integrity", "coverage", "areas", "zones"); // the stream reconnects by itself
    });
  }

  toggleFollow() {
    change({ follow: !settings.follow && settings.selected !== null });
  }

  toggleWatch() {
    const track = this.map.picture?.tracks.get(settings.selected ?? "");
    if (track) change({ watched: toggled(settings.watched, track.watchId) });
  }

  /** Switches between the predicted present picture and the lagged one, which includes late measurements. */
  toggleNow() {
    if (this.status.info?.now === true) change({ at: settings.at === "now" ? "lagged" : "now" });
  }

  /** On a small screen the clock, the sensors and the tools are in a menu. @param {boolean} isOpen */
  openMenu(isOpen) {
    setAttribute(byId("more-button"), "aria-expanded", String(isOpen));
    byId("more").classList.toggle("is-open", isOpen);
  }

  /** On a phone the map fills the screen, and the table opens above it. @param {boolean} isOpen */
  openSheet(isOpen) {
    setAttribute(byId("sheet-button"), "aria-expanded", String(isOpen));
    document.body.classList.toggle("sheet-open", isOpen);
  }

  escape() {
    if (document.querySelector("dialog[open], :popover-open")) return; // the browser closes these
    this.openMenu(false);
    this.openSheet(false);
    if (this.alerts.hasFocus) return this.alerts.open(false);
    if (this.tools.isUsed) return this.tools.end();
    if (document.activeElement === byId("filter-input")) byId("filter-input").blur();
    else change({ selected: null, follow: false });
  }

  /**
   * Shows the pointer's position relative to the radar, and on Earth; nothing without a pointer.
   * @param {number} [px] @param {number} [py]
   */
  showCursor(px, py) {
    const { picture, view } = this.map;
    const readout = byId("readout");
    if (px === undefined || py === undefined || !picture) return setText(readout, "");
    const [x, y] = view.toLocal(px, py);
    const about = picture.frame.isRadar ? `${bearing(x, y).toFixed(1).padStart(5, "0")}°  ${distance(Math.hypot(x, y))}  ` : "";
    setText(readout, about + format.position(...picture.frame.toGeodetic(x, y)));
  }
}
