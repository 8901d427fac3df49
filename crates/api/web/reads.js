// All data that the page requests, by name: whether they are known, and if not, since when and why. Failures are always shown.

const RETRY_MS = 3000;
const TICK_MS = 500;

/**
 * How data are requested and processed.
 * @template T
 * @typedef {{ ask?: (() => Promise<T>) | null, take?: (answer: T) => void, everyMs?: number, isWanted?: () => boolean }} How
 */

/** One kind of requested data. @template [T=any] */
export class Read {
  /** @type {"unknown" | "good" | "failed"} */
  state = "unknown"; // until the first answer or failure
  since = NaN; // for a failure: time of the last good answer, or of the first failure if there was none; ms since 1970
  why = "";
  due = 0; // on the page's monotonic clock
  isAsked = false;

  /** @param {string} title @param {How<T>} how */
  constructor(title, { ask = null, take = () => {}, everyMs = Infinity, isWanted = () => true }) {
    this.title = title;
    this.ask = ask;
    this.take = take;
    this.everyMs = everyMs;
    this.isWanted = isWanted;
  }
}

export class Reads {
  /** @type {Map<ReadName, Read>} */
  all = new Map();

  /**
   * `changed` is called when data become known or unknown; `utc()` is the present time by the service's clock.
   * @param {() => void} changed @param {() => number} utc
   */
  constructor(changed, utc) {
    this.changed = changed;
    this.utc = utc;
    setInterval(() => this.askDue(), TICK_MS);
  }

  /**
   * Adds data that `ask` requests and `take` processes, every `everyMs` while `isWanted`; both throw on failure. Without `ask`
   * the data arrive by events, and their receiver calls `good` or `failed`.
   * @template T @param {ReadName} name @param {string} title @param {How<T>} [how]
   */
  add(name, title, how = {}) {
    this.all.set(name, new Read(title, how));
  }

  /** Requests these data now. @param {...ReadName} names */
  renew(...names) {
    for (const name of names) this.of(name).due = 0;
    this.askDue();
  }

  /** @param {ReadName} name */
  of(name) {
    const read = this.all.get(name);
    if (!read) throw new Error(`no data are called "${name}"`);
    return read;
  }

  /** @param {ReadName} name */
  state(name) {
    return this.of(name).state;
  }

  /** Unavailable data, in the order in which they were added. */
  failures() {
    return [...this.all.values()].filter(({ state }) => state === "failed");
  }

  /** @param {ReadName} name */
  good(name) {
    this.set(name, "good", "", this.utc());
  }

  /** Marks data as unavailable, since their last good answer. @param {ReadName} name @param {string} why */
  failed(name, why) {
    const read = this.of(name);
    this.set(name, "failed", why, read.state === "unknown" ? this.utc() : read.since);
  }

  /** @param {ReadName} name @param {Read["state"]} state @param {string} why @param {number} since */
  set(name, state, why, since) {
    const read = this.of(name);
    const isNews = read.state !== state || read.why !== why;
    Object.assign(read, { state, why, since });
    if (isNews) this.changed();
  }

  askDue() {
    const now = performance.now();
    for (const [name, read] of this.all) {
      const { ask } = read;
      if (!ask || read.isAsked || read.due > now) continue;
      if (read.isWanted()) this.askFor(name, read, ask);
      else this.set(name, "unknown", "", NaN); // the data are not needed
    }
  }

  /** @param {ReadName} name @param {Read} read @param {() => Promise<unknown>} ask */
  async askFor(name, read, ask) {
    read.isAsked = true;
    read.due = Infinity;
    try {
      const answer = await ask();
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
