// All data that the page requests, by name: whether they are known, and if not, since when and why. Failures are always shown.

const RETRY_MS = 3000;
const TICK_MS = 500;

/** One kind of requested data: "unknown" until the first answer or failure, then "good" or "failed". */
class Read {
  state = "unknown";
  since = NaN; // for a failure: time of the last good answer, or of the first failure if there was none; ms since 1970
  why = "";
  due = 0; // on the page's monotonic clock
  isAsked = false;

  constructor(title, { ask = null, take = null, everyMs = Infinity, isWanted = () => true }) {
    Object.assign(this, { title, ask, take, everyMs, isWanted });
  }
}

export class Reads {
  all = new Map(); // by name

  /** `changed` is called when data become known or unknown; `utc()` is the present time by the service's clock. */
  constructor(changed, utc) {
    Object.assign(this, { changed, utc });
    setInterval(() => this.askDue(), TICK_MS);
  }

  /**
   * Adds data that `ask` requests and `take` processes, every `everyMs` while `isWanted`; both throw on failure. Without `ask`
   * the data arrive by events, and their receiver calls `good` or `failed`.
   */
  add(name, title, how = {}) {
    this.all.set(name, new Read(title, how));
  }

  /** Requests these data now. */
  renew(...names) {
    for (const name of names) this.all.get(name).due = 0;
    this.askDue();
  }

  state(name) {
    return this.all.get(name).state;
  }

  /** Unavailable data, in the order in which they were added. */
  failures() {
    return [...this.all.values()].filter(({ state }) => state === "failed");
  }

  good(name) {
    this.set(name, "good", "", this.utc());
  }

  /** Marks data as unavailable, since their last good answer. */
  failed(name, why) {
    const read = this.all.get(name);
    this.set(name, "failed", why, read.state === "unknown" ? this.utc() : read.since);
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
      else this.set(name, "unknown", "", NaN); // the data are not needed
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
    // Earlier if they were requested again meanwhile.
    read.due = Math.min(read.due, performance.now() + (read.state === "failed" ? RETRY_MS : read.everyMs));
  }
}
