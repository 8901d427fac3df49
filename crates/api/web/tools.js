// Tools that receive the clicks on the map: one at a time, with a bar that shows its name, its result and how to end it.

import { byId, setText } from "./dom.js";
import { Measure } from "./measure.js";
import { ZoneTool } from "./zonetool.js";

const NOTE_MS = 500; // measurements from a track change by themselves

export class Tools {
  /** @param {Map2d} map @param {ActiveZones} activeZones */
  constructor(map, activeZones) {
    this.map = map;
    this.zone = new ZoneTool(() => map.picture?.frame, activeZones);
    this.measure = new Measure();
    byId("measure-button").addEventListener("click", () => this.use(this.measure));
    byId("zone-button").addEventListener("click", () => this.use(this.zone));
    byId("tool-undo").addEventListener("click", () => this.do((tool) => tool.undo()));
    byId("tool-clear").addEventListener("click", () => this.do((tool) => tool.clear()));
    byId("tool-end").addEventListener("click", () => this.end());
    map.canvas.addEventListener("keydown", (event) => this.key(event));
    setInterval(() => this.note(), NOTE_MS);
  }

  get isUsed() {
    return this.map.tool !== null;
  }

  /** @param {Tool} tool */
  use(tool) {
    if (!this.map.picture) return;
    byId("tools").hidePopover();
    this.map.tool = tool;
    tool.clear();
    byId("tool-bar").hidden = false;
    byId("zone-panel").hidden = tool !== this.zone;
    setText(byId("tool-title"), tool.title);
    setText(byId("tool-hint"), tool.hint);
    this.map.canvas.focus();
    this.note();
    this.map.invalidate();
  }

  toggleMeasure() {
    if (this.map.tool === this.measure) this.end();
    else this.use(this.measure);
  }

  /** @param {(tool: Tool) => void} act */
  do(act) {
    if (!this.map.tool) return;
    act(this.map.tool);
    this.note();
    this.map.invalidate();
  }

  end() {
    this.do((tool) => tool.clear());
    this.map.tool = null;
    byId("tool-bar").hidden = true;
    byId("zone-panel").hidden = true;
    this.map.invalidate();
  }

  /** Keyboard control: arrow keys pan, Enter acts on the middle. @param {KeyboardEvent} event */
  key(event) {
    if (!this.isUsed || event.key !== "Enter") return;
    event.preventDefault();
    const { view } = this.map;
    this.map.click(view.width / 2, view.height / 2);
    this.note();
  }

  note() {
    if (this.map.tool) setText(byId("tool-words"), this.map.tool.words());
  }
}
