// Conflicts: lines from both aircraft to their closest point of approach, and those without an alert as a folded list.

import { list } from "./api.js";
import { byId, element, setText } from "./dom.js";
import { nameOf } from "./names.js";
import { palette } from "./palette.js";
import { placesOf } from "./trust.js";
import { distance } from "./units.js";

/** @typedef {Exclude<Conflict["level"], "none">} Level */

/** @type {Record<Level, number>} */
const RANK = { violation: 0, warning: 1, advisory: 2 };
/** @type {Record<Level, Colour>} */
const COLOURS = { violation: "critical", warning: "warning", advisory: "quiet" };
const MOST = 50; // maximum shown; a count covers the rest
const REASK_MS = 10000; // used if the service computes none
const LOOK_MS = 1000;
const OLD_MS = 3000; // they come every second; older ones are misleading
const CROSS_PX = 4;

export class Conflicts {
  /** @type {(Conflict & { level: Level })[]} */
  known = []; // highest level first, then soonest
  reason = ""; // reason why there are no current ones
  isComputed = true; // until the service states otherwise
  wereComputed = false; // on this page: a user who relied on them must see that they are missing
  takenAt = -Infinity; // on the page's monotonic clock
  /** @type {Set<string>[]} */
  covered = []; // tracks of each conflict that has an alert
  next = 0; // time of the next request to a service that computes none, on the same clock

  /** @param {Map2d} map */
  constructor(map) {
    this.map = map;
    byId("other-conflicts").addEventListener("toggle", () => this.show());
    setInterval(() => {
      if (this.known.length && performance.now() - this.takenAt > OLD_MS) this.forget("no answer for some seconds");
    }, LOOK_MS);
    this.show();
  }

  /** Every second if conflicts are computed, rarely if not. */
  get isWanted() {
    return this.isComputed || performance.now() >= this.next;
  }

  /** Takes the answer of /conflicts. @param {ConflictsAnswer} answer */
  take(answer) {
    this.known = list(answer, "conflicts")
      .filter(hasLevel)
      .sort((a, b) => RANK[a.level] - RANK[b.level] || ahead(a) - ahead(b));
    this.takenAt = performance.now();
    this.isComputed = answer.computed === true;
    this.wereComputed ||= this.isComputed;
    this.reason = this.isComputed ? "" : (answer.reason ?? "the service does not say why");
    if (!this.isComputed) this.next = this.takenAt + REASK_MS;
    this.show();
    this.map.invalidate();
  }

  /** Discards the known conflicts; `why` is the reason to show, if any. @param {string} why */
  forget(why) {
    if (why) this.reason = why;
    this.known = [];
    this.show();
    this.map.invalidate();
  }

  /** `covered`: tracks of each conflict that has an alert. @param {Set<string>[]} covered */
  cover(covered) {
    this.covered = covered;
    this.show();
  }

  /** Lists the conflicts that no alert covers: advisories, and those that a rule or the alert about a lying transponder silences. */
  show() {
    const reason = this.wereComputed ? this.reason : "";
    setText(byId("conflict-reason"), reason && `Conflicts are not known now: ${reason}. That none is listed does not mean that there are none.`);
    const others = this.known.filter(({ a, b }) => !this.covered.some((tracks) => tracks.has(a) && tracks.has(b)));
    byId("other-conflicts").hidden = !others.length;
    setText(byId("other-count"), String(others.length));
    if (byId("other-conflicts", HTMLDetailsElement).open) byId("other-list").replaceChildren(...others.slice(0, MOST).map((conflict) => this.row(conflict)));
  }

  /** @param {Conflict} conflict */
  row(conflict) {
    const { a, b, level, volume, probability } = conflict;
    const when = ahead(conflict) > 0 ? `in ${Math.round(ahead(conflict))} s` : "now";
    const words = `${nameOf(a)} – ${nameOf(b)}: ${apart(conflict)}, ${when} (${volume}, ${Math.round(100 * probability)} %)`;
    const show = element("button", { type: "button", class: "situation", title: "Show on the map" }, element("span", { class: "severity" }, level), " ", words);
    show.addEventListener("click", () => this.map.go([a, b]));
    return element("li", { "data-severity": level }, show);
  }

  /**
   * Draws lines from both aircraft to their closest point of approach.
   * @param {Context} context @param {View} view @param {Placed[]} placed @param {Frame} frame
   */
  draw(context, view, placed, frame) {
    if (!this.known.length) return;
    const places = placesOf(placed);
    context.save();
    for (const conflict of this.known) {
      const colour = palette[COLOURS[conflict.level]];
      const ends = /** @type {const} */ (["a", "b"]).map((side) => {
        const [longitude, latitude] = conflict.cpa[side];
        return /** @type {const} */ ([places.get(conflict[side]), view.toScreen(...frame.toLocal(latitude, longitude))]);
      });
      if (!ends.some(([, [x, y]]) => view.contains(x, y, 50))) continue;
      context.strokeStyle = colour;
      context.lineWidth = conflict.level === "advisory" ? 1 : 2;
      context.setLineDash(conflict.level === "advisory" ? [3, 4] : []);
      context.beginPath();
      for (const [from, [x, y]] of ends) {
        if (from) {
          context.moveTo(...from);
          context.lineTo(x, y);
        }
        context.moveTo(x - CROSS_PX, y - CROSS_PX);
        context.lineTo(x + CROSS_PX, y + CROSS_PX);
        context.moveTo(x - CROSS_PX, y + CROSS_PX);
        context.lineTo(x + CROSS_PX, y - CROSS_PX);
      }
      context.stroke();
    }
    context.restore();
  }
}

/** @param {Conflict} conflict @returns {conflict is Conflict & { level: Level }} */
const hasLevel = (conflict) => conflict.level in RANK;

/**
 * Seconds to the closest approach; to the entry of the volume if they are nearest over ground now, as in a descent.
 * @param {Conflict} conflict
 */
const ahead = ({ t_cpa_s, t_entry_s }) => (t_cpa_s > 0 ? t_cpa_s : (t_entry_s ?? 0));

/** Distances as text: "34 m, 7 m in height". @param {Conflict} conflict */
function apart({ t_cpa_s, d_cpa_h_m, d_cpa_v_m, d_now_h_m, d_now_v_m }) {
  const [over, above] = t_cpa_s > 0 ? [d_cpa_h_m, d_cpa_v_m] : [d_now_h_m, d_now_v_m];
  const words = Number.isFinite(above) ? `${distance(above)} in height` : "height not known";
  return `${distance(over)}, ${words}`;
}
