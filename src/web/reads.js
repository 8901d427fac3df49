// All that the page asks for, each by its name: whether it is known, and if not, since when and why. Nothing that fails is
// passed over: what is not known is said to be so.

const RETRY_MS = 3000;
const TICK_MS = 500;

/** One thing that is asked for: "unknown" until it was answered or failed for the first time, then "good" or "failed". */
class Read {
  state = "unknown";
  since = NaN; // of one that failed: the last good answer, or the first failure where there was none; ms since 1970
  why = "";
  due = 0; // on the page's monotonic clock
  isAsked = false;

  constructor(title, { ask = null, take = null, everyMs = Infinity, isWanted = () => true }) {
    Object.assign(this, { title, ask, take, everyMs, isWanted });
  }
}

export class Reads {
  all = new Map(); // by name

  /** `changed` is called when one of them became known, or is no longer. */
  constructor(changed) {
    this.changed = changed;
    setInterval(() => this.askDue(), TICK_MS);
  }

  /**
   * Something that `ask` answers and `take` takes, each `everyMs` while it `isWanted`; either throws where it cannot. Without
   * `ask` it comes by itself, and whoever hears it says so: `good`, `failed`.
   */
  add(name, title, how = {}) {
    this.all.set(name, new Read(title, how));
  }

  /** Asks for these now. */
  renew(...names) {
    for (const name of names) this.all.get(name).due = 0;
    this.askDue();
  }

  state(name) {
    return this.all.get(name).state;
  }

  /** Those that are not known, in the order in which they were added. */
  failures() {
    return [...this.all.values()].filter(({ state }) => state === "failed");
  }

  good(name) {
    this.set(name, "good", "", Date.now());
  }

  /** It is not known from now on; where it was good, since it was so last. */
  failed(name, why) {
    const read = this.all.get(name);
    this.set(name, "failed", why, read.state === "unknown" ? Date.now() : read.since);
  }

  set(name, state, why, since) {
    const read = this.all.get(name);
    const isNews = read.state !== state || read.why !== why;
    Object.assign(read, { state, why, since });
    if (isNews) this.changed();
  }

  askDue() {
    const now = performance.now();
    for (const [name, read] of this.all) {
      if (!read.ask || read.isAsked || read.due > now) continue;
      if (read.isWanted()) this.askFor(name, read);
      else this.set(name, "unknown", "", NaN); // and it does not matter
    }
  }

  async askFor(name, read) {
    read.isAsked = true;
    read.due = Infinity;
    try {
      const answer = await read.ask();
      if (read.isWanted()) read.take(answer);
      this.good(name);
    } catch (error) {
      this.failed(name, error.message);
    }
    read.isAsked = false;
    // Sooner where somebody has asked for it meanwhile.
    read.due = Math.min(read.due, performance.now() + (read.state === "failed" ? RETRY_MS : read.everyMs));
  }
}
