// Estimate of the service's clock. The display's own clock may be wrong, so it never decides how old a picture is.

const KEPT_MS = 60000; // an older sample is replaced by the next one, because clocks drift apart
const JUMP_MS = 1000; // larger changes between the display's two clocks: it slept, or its clock was set
const LOOK_MS = 250;

/** Times are in ms since 1970 (UTC), and moments are on the page's monotonic clock. */
export class ServiceClock {
  /**
   * UTC minus monotonic clock, maximum error, and moment of the answer.
   * @type {{ offset: number, error: number, at: number } | null}
   */
  sample = null;
  published = NaN; // the same offset from the last event, which is too small by the event's delay

  /**
   * `jumped(ms)` is called after the display slept or its clock was set: time that the monotonic clock may have missed.
   * @param {(ms: number) => void} jumped
   */
  constructor(jumped) {
    let before = Date.now() - performance.now();
    setInterval(() => {
      const now = Date.now() - performance.now();
      const jump = now - before;
      before = now;
      if (Math.abs(jump) < JUMP_MS) return;
      this.sample = null;
      jumped(jump);
    }, LOOK_MS);
  }

  /**
   * Takes the time in an answer to a request that was sent at `asked` and answered at `received`.
   * @param {number} time @param {number} asked @param {number} received
   */
  answered(time, asked, received) {
    if (!Number.isFinite(time)) return;
    const sample = { offset: time - (asked + received) / 2, error: (received - asked) / 2, at: received };
    const { offset, error, at } = this.sample ?? { offset: 0, error: Infinity, at: -Infinity };
    const isContradicted = Math.abs(sample.offset - offset) > sample.error + error; // a clock was set
    if (sample.error <= error || received - at > KEPT_MS || isContradicted) this.sample = sample;
  }

  /**
   * Takes the time at which an event was published; it was received at `received`.
   * @param {number} time @param {number} received
   */
  noted(time, received) {
    if (Number.isFinite(time)) this.published = time - received;
  }

  /** Whether the service's clock is known well enough to judge the age of a picture. */
  get isKnown() {
    return this.sample !== null;
  }

  /** UTC by the service's clock; by the display's while nothing was received. */
  now() {
    const offset = this.sample?.offset ?? this.published;
    return Number.isFinite(offset) ? performance.now() + offset : Date.now();
  }
}
