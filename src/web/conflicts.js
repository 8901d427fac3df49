// Who will come near whom: a line from each of the two to where it is closest, and a list, the soonest first.

import { list } from "./api.js";
import { byId, element, setText } from "./dom.js";
import { FONT, writeFree } from "./furniture.js";
import { shortName } from "./names.js";
import { palette } from "./palette.js";
import { change } from "./settings.js";
import { distance } from "./units.js";

const RANK = { violation: 0, warning: 1, advisory: 2 };
const COLOURS = { violation: "critical", warning: "warning", advisory: "quiet" };
const MOST = 50; // shown; the count tells of the rest
const REASK_MS = 10000; // where the service computes none
const LOOK_MS = 1000;
const OLD_MS = 3000; // they come each second: what is older than this misleads
const CROSS_PX = 4;

export class Conflicts {
  known = []; // the worst first, then the soonest
  reason = ""; // why there are none to be relied on
  isComputed = true; // until the service says otherwise
  wereComputed = false; // on this page: whoever has relied on them has to see that they are gone
  takenAt = -Infinity; // on the page's monotonic clock
  next = 0; // when a service that computes none is asked again, on the same clock

  /** `trackOf(id)`: the track as it is shown, if it is. */
  constructor(map, trackOf) {
    [this.map, this.trackOf] = [map, trackOf];
    setInterval(() => {
      if (this.known.length && performance.now() - this.takenAt > OLD_MS) this.forget("no answer for some seconds");
    }, LOOK_MS);
    this.show();
  }

  /** Each second where there are some to be computed, and now and then where there are none. */
  get isWanted() {
    return this.isComputed || performance.now() >= this.next;
  }

  /** The answer of /conflicts. */
  take(answer) {
    this.known = list(answer, "conflicts")
      .filter(({ level }) => level in RANK)
      .sort((a, b) => RANK[a.level] - RANK[b.level] || a.t_cpa_s - b.t_cpa_s);
    this.takenAt = performance.now();
    this.isComputed = answer.computed === true;
    this.wereComputed ||= this.isComputed;
    this.reason = this.isComputed ? "" : (answer.reason ?? "the service does not say why");
    if (!this.isComputed) this.next = this.takenAt + REASK_MS;
    this.show();
    this.map.invalidate();
  }

  /** What was known is no longer; `why`, unless nobody wants to know. */
  forget(why) {
    if (why) this.reason = why;
    this.known = [];
    this.show();
    this.map.invalidate();
  }

  show() {
    const reason = this.wereComputed ? this.reason : "";
    byId("conflicts").hidden = !this.known.length && !reason;
    byId("conflict-table").hidden = !this.known.length;
    setText(byId("conflict-reason"), reason && `Not known now: ${reason}. That none is listed does not mean that there are none.`);
    setText(byId("conflict-count"), reason ? "?" : String(this.known.length));
    byId("conflict-rows").replaceChildren(...this.known.slice(0, MOST).map((conflict) => this.row(conflict)));
  }

  row(conflict) {
    const { a, b, level, volume, t_cpa_s, probability } = conflict;
    const select = element("button", { type: "button", title: `Select ${a}` }, `${this.nameOf(a)} – ${this.nameOf(b)}`);
    select.addEventListener("click", () => change({ selected: a }));
    const cells = [level, volume, t_cpa_s > 0 ? `${Math.round(t_cpa_s)} s` : "now", apart(conflict), `${Math.round(100 * probability)} %`];
    return element("tr", { "data-level": level }, element("td", {}, select), ...cells.map((text) => element("td", {}, text)));
  }

  nameOf(id) {
    const track = this.trackOf(id);
    return track ? shortName(track) : id;
  }

  /** From where both are shown to where they are closest. */
  draw(context, view, placed, frame) {
    if (!this.known.length) return;
    const places = new Map(placed.map(([track, px, py]) => [track.id, [px, py]]));
    context.save();
    context.font = FONT;
    context.textAlign = "center";
    context.textBaseline = "middle";
    for (const conflict of this.known) {
      const colour = palette[COLOURS[conflict.level]];
      const ends = ["a", "b"].map((side) => {
        const [longitude, latitude] = conflict.cpa[side];
        return [places.get(conflict[side]), view.toScreen(...frame.toLocal(latitude, longitude))];
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
      const [[, [ax, ay]], [, [bx, by]]] = ends;
      const when = conflict.t_cpa_s > 0 ? `in ${Math.round(conflict.t_cpa_s)} s: ` : "";
      writeFree(context, view, when + apart(conflict), (ax + bx) / 2, (ay + by) / 2 - 12, colour);
    }
    context.restore();
  }
}

/** "34 m, 7 m in height" */
function apart({ t_cpa_s, d_cpa_h_m, d_cpa_v_m, d_now_h_m, d_now_v_m }) {
  const [over, above] = t_cpa_s > 0 ? [d_cpa_h_m, d_cpa_v_m] : [d_now_h_m, d_now_v_m];
  const words = Number.isFinite(above) ? `${distance(above)} in height` : "height not known";
  return `${distance(over)}, ${words}`;
}
