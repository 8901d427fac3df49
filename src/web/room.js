// Where on the canvas there is room for text: not below buttons, not on symbols or other text, and rather not on trails.

const CELL_PX = 64; // boxes are kept by cell, so that 500 labels need not be compared with each other
const TRACE_PX = 8;

/** Boxes are [left, top, right, bottom]. One room lasts for one frame. */
export class Room {
  cells = new Map();

  /** `covered`: what lies over the canvas. */
  constructor(width, height, covered) {
    Object.assign(this, { width, height, covered });
    this.across = Math.ceil(width / TRACE_PX) + 1;
    this.traces = new Uint8Array(this.across * (Math.ceil(height / TRACE_PX) + 1));
  }

  /** Whether all of a box is on the canvas, and nothing lies over it or was written there. */
  isFree(box) {
    const [left, top, right, bottom] = box;
    if (left < 0 || top < 0 || right > this.width || bottom > this.height) return false;
    if (this.covered.some((other) => meet(box, other))) return false;
    for (const cell of around(box)) if (this.cells.get(cell)?.some((other) => meet(box, other))) return false;
    return true;
  }

  take(box) {
    for (const cell of around(box)) {
      const boxes = this.cells.get(cell);
      if (boxes) boxes.push(box);
      else this.cells.set(cell, [box]);
    }
  }

  /** A trail goes through here. */
  trace(px, py) {
    if (px < 0 || py < 0 || px > this.width || py > this.height) return;
    this.traces[Math.floor(py / TRACE_PX) * this.across + Math.floor(px / TRACE_PX)] = 1;
  }

  /** How much of a free box trails go through, in cells of 8 pixels. */
  traced([left, top, right, bottom]) {
    let count = 0;
    for (let y = Math.floor(top / TRACE_PX); y <= Math.floor(bottom / TRACE_PX); y++) {
      for (let x = Math.floor(left / TRACE_PX); x <= Math.floor(right / TRACE_PX); x++) count += this.traces[y * this.across + x];
    }
    return count;
  }
}

const meet = (a, b) => a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3];

function* around([left, top, right, bottom]) {
  for (let x = Math.floor(left / CELL_PX); x <= Math.floor(right / CELL_PX); x++) {
    for (let y = Math.floor(top / CELL_PX); y <= Math.floor(bottom / CELL_PX); y++) yield x * 4096 + y;
  }
}

/** The boxes of all that lies over the canvas; found anew when one of them or the canvas has another size, not at each frame. */
export class Covers {
  boxes = [];
  isKnown = false;

  /** `changed` is called when they may be elsewhere. */
  constructor(canvas, changed) {
    this.canvas = canvas;
    const observer = new ResizeObserver(() => {
      this.isKnown = false; // one that is hidden or shown has another size, too
      changed();
    });
    for (const node of [canvas, ...this.nodes()]) observer.observe(node);
  }

  /** Of what only arranges others, the others. */
  nodes() {
    return this.canvas.parentElement.querySelectorAll(":scope > :not(canvas, .tool), .tool > *");
  }

  find() {
    if (this.isKnown) return this.boxes;
    this.isKnown = true;
    const { left, top } = this.canvas.getBoundingClientRect();
    this.boxes = [];
    for (const node of this.nodes()) {
      const box = node.getBoundingClientRect(); // without an extent where it is hidden
      if (box.width) this.boxes.push([box.left - left, box.top - top, box.right - left, box.bottom - top]);
    }
    return this.boxes;
  }
}
