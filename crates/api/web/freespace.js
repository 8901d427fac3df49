// Free space for text on the canvas: not under buttons, not on symbols or other text, and preferably not on trails.

const CELL_PX = 64; // boxes are stored by cell, so that 500 labels need not be compared with each other
const TRACE_PX = 8;

/** Boxes are [left, top, right, bottom]. An instance is used for one frame. */
export class FreeSpace {
  /** `covered`: boxes of elements above the canvas. @param {number} width @param {number} height @param {Box[]} covered */
  constructor(width, height, covered) {
    this.width = width;
    this.height = height;
    this.covered = covered;
    this.columns = Math.ceil(width / CELL_PX) + 1;
    this.cells = Array.from({ length: this.columns * (Math.ceil(height / CELL_PX) + 1) }, () => []);
    this.across = Math.ceil(width / TRACE_PX) + 1;
    this.traces = new Uint8Array(this.across * (Math.ceil(height / TRACE_PX) + 1));
  }

  /** Whether a box is completely on the canvas and free. @param {Box} box */
  isFree(box) {
    const [left, top, right, bottom] = box;
    if (left < 0 || top < 0 || right > this.width || bottom > this.height) return false;
    return !this.covered.some((other) => meet(box, other)) && !this.someCell(box, (boxes) => boxes.some((other) => meet(box, other)));
  }

  /** @param {Box} box */
  occupy(box) {
    this.someCell(box, (boxes) => {
      boxes.push(box);
      return false; // continues, so that the box is added to each of its cells
    });
  }

  /** Whether `is` holds for one of the cells that a box touches. @param {Box} box @param {(boxes: Box[]) => boolean} is */
  someCell([left, top, right, bottom], is) {
    const last = Math.min(this.columns - 1, Math.floor(right / CELL_PX));
    const lowest = Math.min(this.cells.length / this.columns - 1, Math.floor(bottom / CELL_PX));
    for (let y = Math.max(0, Math.floor(top / CELL_PX)); y <= lowest; y++) {
      for (let x = Math.max(0, Math.floor(left / CELL_PX)); x <= last; x++) if (is(this.cells[y * this.columns + x])) return true;
    }
    return false;
  }

  /** Marks a point of a trail. @param {number} px @param {number} py */
  trace(px, py) {
    if (px < 0 || py < 0 || px > this.width || py > this.height) return;
    this.traces[Math.floor(py / TRACE_PX) * this.across + Math.floor(px / TRACE_PX)] = 1;
  }

  /** Number of 8-pixel cells of a box that trails cross. @param {Box} box */
  traced([left, top, right, bottom]) {
    let count = 0;
    for (let y = Math.floor(top / TRACE_PX); y <= Math.floor(bottom / TRACE_PX); y++) {
      for (let x = Math.floor(left / TRACE_PX); x <= Math.floor(right / TRACE_PX); x++) count += this.traces[y * this.across + x];
    }
    return count;
  }
}

/** @param {Box} a @param {Box} b */
const meet = (a, b) => a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3];

/**
 * Boxes of all elements above the canvas. They are computed again when an element or the canvas changes its size, not at each
 * frame.
 */
export class Covers {
  /** @type {Box[]} */
  boxes = [];
  isKnown = false;

  /** `changed` is called when they may have moved. @param {HTMLCanvasElement} canvas @param {() => void} changed */
  constructor(canvas, changed) {
    this.canvas = canvas;
    const observer = new ResizeObserver(() => {
      this.isKnown = false; // hiding or showing an element changes its size too
      changed();
    });
    for (const node of [canvas, ...this.nodes()]) observer.observe(node);
  }

  /** Elements; a container is replaced by its children. */
  nodes() {
    return (this.canvas.parentElement ?? this.canvas).querySelectorAll(":scope > :not(canvas, .tool), .tool > *");
  }

  find() {
    if (this.isKnown) return this.boxes;
    this.isKnown = true;
    const { left, top } = this.canvas.getBoundingClientRect();
    this.boxes = [];
    for (const node of this.nodes()) {
      const box = node.getBoundingClientRect(); // a hidden element has no extent
      if (box.width) this.boxes.push([box.left - left, box.top - top, box.right - left, box.bottom - top]);
    }
    return this.boxes;
  }
}
