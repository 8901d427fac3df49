// The table of tracks. Only visible rows exist; they are filled again every second.

import { precedence } from "./attention.js";
import { byId, element, find, setAttribute, setText } from "./dom.js";
import * as format from "./format.js";
import { shortName } from "./names.js";
import { change, isFilter, onChange, settings, SOURCES } from "./settings.js";
import { isFlagged, markOf, rankOf, stateOf, wordsOf } from "./trust.js";
import { climbArrow, distanceUnit, HEIGHTS, heightUnit, heightWords, plainDistance, plainHeight, plainSpeed } from "./units.js";

const ROW_PX = 24; // as in the style sheet
const HEAD_PX = 32;
const SPARE_ROWS = 4;
const EVERY_MS = 1000;

/** @param {Track} track */
const approximate = (track) => (track.derived ? "≈" : "");

/** @typedef {string | number | null | undefined} SortKey */

/**
 * Columns: name, heading, description, value to sort by, text.
 * @type {[string, () => string, () => string, (track: Track) => SortKey, (track: Track) => string][]}
 */
const COLUMNS = [
  ["source", () => "Src", () => "Source: the watch list and unidentified tracks first", precedence, () => ""],
  ["number", () => "Track", () => "Name of the track", shortName, shortName],
  ["serial", () => "Serial", () => "Serial number, or callsign", (track) => track.serial, (track) => track.properties.aircraft?.callsign ?? (track.serial || "–")],
  ["trust", () => "Trust", () => "Whether its transponder can be trusted", rankOf, markOf],
  ["height", () => (heightUnit() === "FL" ? "FL" : `Alt ${HEIGHTS[heightUnit()][1]}`), () => `Height, ${heightWords()}; an arrow where it climbs or sinks`, (track) => track.properties.alt_msl, (track) => plainHeight(track.properties.alt_msl) + (climbArrow(track) || "\u2007")],
  ["speed", () => settings.units.speed, () => "Speed over ground", (track) => track.speed, (track) => (Number.isFinite(track.speed) ? approximate(track) : "") + plainSpeed(track.speed)],
  ["course", () => "Crs °", () => "Course over ground, degrees true", (track) => track.course, (track) => format.direction(track.course)],
  ["range", () => `Dist ${distanceUnit()}`, () => `Distance from the radar, ${distanceUnit()}`, (track) => track.range, (track) => plainDistance(track.range)],
  ["bearing", () => "Brg °", () => "Bearing from the radar, degrees true", (track) => track.bearing, (track) => format.direction(track.bearing)],
  ["uav", () => "Drone", () => "Probability that it is a drone, by the radar's classifier", (track) => track.properties.uav_probability, (track) => format.percent(track.properties.uav_probability)],
];

/** Columns that are hidden while none of the shown tracks has a value. */
const OPTIONAL = ["trust", "range", "bearing", "uav"];

/** @param {SortKey} key */
const isUnknown = (key) => key == null || key === "" || Number.isNaN(key);
const collator = new Intl.Collator("en", { numeric: true });

export class Table {
  /** @type {Picture | null} */
  picture = null;
  /** @type {Track[]} */
  rows = []; // filtered and sorted
  /** @type {HTMLTableRowElement[]} */
  pool = [];

  /**
   * `isKnown()`: whether the tracks are the current ones of the service; `whyEmpty()`: reason why there are none.
   * @param {() => boolean} isKnown @param {() => string} whyEmpty
   */
  constructor(isKnown, whyEmpty) {
    this.isKnown = isKnown;
    this.whyEmpty = whyEmpty;
    this.scroll = byId("table-scroll");
    this.body = byId("table-body");
    this.above = element("tr", { class: "spacer", "aria-hidden": "true" });
    this.below = element("tr", { class: "spacer", "aria-hidden": "true" });
    this.body.append(this.above, this.below);
    this.makeHead();
    this.scroll.addEventListener("scroll", () => this.fill(), { passive: true });
    this.scroll.addEventListener("keydown", (event) => this.key(event));
    new ResizeObserver(() => {
      this.reveal(); // the details may cover the selected row
      this.fill();
    }).observe(this.scroll);
    onChange((patch) => {
      if ("sort" in patch) this.markSort();
      if ("selected" in patch) this.reveal();
      if ("units" in patch || "groundM" in patch) this.nameColumns();
      if (isFilter(patch) || ["sort", "selected", "watched", "units", "groundM"].some((name) => name in patch)) this.refresh();
    });
    setInterval(() => this.refresh(), EVERY_MS);
  }

  makeHead() {
    for (const [name] of COLUMNS) {
      const button = element("button", { type: "button" });
      button.addEventListener("click", () => {
        const { column, descending } = settings.sort;
        change({ sort: { column: name, descending: column === name && !descending } });
      });
      byId("table-head").append(element("th", { scope: "col", class: name, "data-column": name }, button));
    }
    this.nameColumns();
    this.markSort();
  }

  nameColumns() {
    COLUMNS.forEach(([, heading, meaning], i) => {
      const [button] = byId("table-head").children[i].children;
      setText(button, heading());
      setAttribute(button, "title", `Sort by: ${meaning()}`);
    });
  }

  markSort() {
    const { column, descending } = settings.sort;
    for (const heading of byId("table-head").children) {
      const order = heading.getAttribute("data-column") === column ? (descending ? "descending" : "ascending") : "none";
      setAttribute(heading, "aria-sort", order);
    }
  }

  refresh() {
    const isKnown = this.isKnown();
    const tracks = [...(this.picture?.tracks.values() ?? [])];
    for (const source of SOURCES) {
      const button = find(byId("sources"), `[data-source=${source}]`);
      const count = tracks.filter((track) => track.source === source).length;
      setText(find(button, ".count"), isKnown ? String(count) : "?");
      button.hidden = source === "camera" && count === 0;
    }
    const flagged = byId("flagged");
    const count = tracks.filter(isFlagged).length;
    flagged.hidden = count === 0 && !settings.flagged;
    setText(find(flagged, ".count"), isKnown ? String(count) : "?");
    this.rows = this.sorted(this.picture?.visible() ?? []);
    const total = isKnown ? tracks.length : "?";
    const empty = byId("table-empty");
    empty.hidden = this.rows.length > 0;
    setText(empty, tracks.length ? `None of ${total} tracks matches the filter` : this.whyEmpty());
    const note = byId("map-empty");
    note.hidden = tracks.length > 0;
    if (!tracks.length) setText(note, this.whyEmpty());
    this.hideEmptyColumns();
    this.fill();
  }

  hideEmptyColumns() {
    for (const [name, , , , text] of COLUMNS) {
      if (!OPTIONAL.includes(name)) continue;
      const isEmpty = this.rows.length > 0 && this.rows.every((track) => ["", "–"].includes(text(track)));
      byId("table").classList.toggle(`no-${name}`, isEmpty);
    }
  }

  /** @param {Track[]} tracks */
  sorted(tracks) {
    const value = (COLUMNS.find(([name]) => name === settings.sort.column) ?? COLUMNS[0])[3];
    const sign = settings.sort.descending ? -1 : 1;
    return tracks
      .map((track) => /** @type {const} */ ([value(track), track]))
      .sort(([a, one], [b, other]) => {
        // Unknown values come last in either direction. Equal values are in the order of names.
        if (isUnknown(a) !== isUnknown(b)) return Number(isUnknown(a)) - Number(isUnknown(b));
        const order = isUnknown(a) ? 0 : typeof a === "number" && typeof b === "number" ? a - b : collator.compare(String(a), String(b));
        return sign * order || collator.compare(shortName(one), shortName(other)) || collator.compare(one.id, other.id);
      })
      .map(([, track]) => track);
  }

  fill() {
    const first = Math.max(0, Math.floor(this.scroll.scrollTop / ROW_PX) - SPARE_ROWS);
    const count = Math.ceil(this.scroll.clientHeight / ROW_PX) + 2 * SPARE_ROWS;
    const shown = this.rows.slice(first, first + count);
    while (this.pool.length < shown.length) this.pool.push(this.makeRow());
    this.pool.splice(shown.length).forEach((row) => row.remove());
    shown.forEach((track, i) => this.fillRow(this.pool[i], track, first + i));
    this.above.style.height = `${first * ROW_PX}px`;
    this.below.style.height = `${Math.max(0, this.rows.length - first - shown.length) * ROW_PX}px`;
    setAttribute(byId("table"), "aria-rowcount", String(this.rows.length + 1));
  }

  makeRow() {
    const row = element("tr");
    for (const [name] of COLUMNS) row.append(element("td", { class: name }));
    row.addEventListener("click", () => change({ selected: row.dataset.id }));
    this.body.insertBefore(row, this.below);
    return row;
  }

  /** @param {HTMLTableRowElement} row @param {Track} track @param {number} index */
  fillRow(row, track, index) {
    row.dataset.id = track.id;
    setAttribute(row, "aria-rowindex", String(index + 2));
    setAttribute(row, "aria-current", String(track.id === settings.selected));
    COLUMNS.forEach(([name, , , , text], i) => {
      const cell = row.children[i];
      if (name === "source") {
        setAttribute(cell, "data-source", track.source);
        setAttribute(cell, "aria-label", track.source);
        cell.classList.toggle("hollow", track.isDoubtful);
        row.classList.toggle("unknown", track.isUnknown);
        row.classList.toggle("watched", settings.watched.has(track.watchId));
      } else {
        setText(cell, text(track));
        if (name === "trust") {
          setAttribute(cell, "data-trust", stateOf(track));
          setAttribute(cell, "title", wordsOf(track));
          setAttribute(cell, "aria-label", wordsOf(track));
        }
        if (name === "number") setAttribute(cell, "title", shortName(track));
        if (name === "serial") setAttribute(cell, "title", track.serial); // the text may be too long for its column
      }
    });
  }

  /** Scrolls to the selected row if it is not visible. */
  reveal() {
    const index = this.rows.findIndex((track) => track.id === settings.selected);
    if (index < 0) return;
    // The heading stays above the rows, so its height is added below.
    const [highest, lowest] = [index * ROW_PX, HEAD_PX + (index + 1) * ROW_PX - this.scroll.clientHeight];
    if (this.scroll.scrollTop > highest) this.scroll.scrollTop = highest;
    else if (this.scroll.scrollTop < lowest) this.scroll.scrollTop = lowest;
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    const step = { ArrowDown: 1, ArrowUp: -1, PageDown: 10, PageUp: -10, Home: -Infinity, End: Infinity }[event.key];
    if (!step || !this.rows.length || event.target instanceof Element && event.target.closest("th")) return;
    event.preventDefault();
    event.stopPropagation();
    const now = this.rows.findIndex((track) => track.id === settings.selected);
    const next = now < 0 ? 0 : Math.max(0, Math.min(this.rows.length - 1, now + step));
    change({ selected: this.rows[next].id });
  }
}
