// The service's HTTP interface. URLs are relative, so that the page works behind a proxy's path too.

/** @param {string} path */
const address = (path) => new URL(`api/v1/${path}`, document.baseURI);

// A service on the network requires a token. It is stored for this tab only, and removed with it.
const TOKEN = "utm-fusion-token";
let askForToken = () => {};
/** @param {() => void} ask */
export const onUnauthorized = (ask) => (askForToken = ask);
export const askForAnother = () => askForToken();
/** @param {string} token */
export const setToken = (token) => sessionStorage.setItem(TOKEN, token);
export const hasToken = () => sessionStorage.getItem(TOKEN) !== null;

const UPDATE_MS = 1000; // 430 tracks need 0.4 Mbit/s; with every slot it would be 1.5
const LONGEST_ANSWER_MS = 10000;

function headers() {
  const token = sessionStorage.getItem(TOKEN);
  return { accept: "application/json", ...(token ? { authorization: `Bearer ${token}` } : {}) };
}

/** @template {string} Path @param {Path} path @returns {Promise<Answer<Path>>} */
export const get = (path) => answer(address(path), {});

/** A binary answer. @param {string} path */
export async function getOctets(path) {
  const response = await exchange(address(path), {});
  if (!response.ok) return answered(response); // throws the problem as text
  return new Uint8Array(await inTime(response.arrayBuffer()));
}

/**
 * `value` is sent as JSON in the body.
 * @template {string} Path
 * @param {Path} path @param {Record<string, string | number>} [parameters] @param {object | null} [value]
 * @returns {Promise<Posted<Path>>}
 */
export function post(path, parameters = {}, value = null) {
  const url = address(path);
  for (const [name, value] of Object.entries(parameters)) url.searchParams.set(name, String(value));
  const body = value === null ? {} : { body: JSON.stringify(value), headers: { "content-type": "application/json" } };
  return answer(url, { method: "POST", ...body });
}

/**
 * URL of the stream. An EventSource cannot send headers, so with a token the URL contains a short-lived ticket.
 * @param {StreamWish} wish
 */
async function streamAddress({ at, trailS }) {
  const url = address("stream");
  url.searchParams.set("trail_s", String(trailS)); // trails are available at once
  url.searchParams.set("interval_ms", String(UPDATE_MS));
  if (at !== "lagged") url.searchParams.set("at", at);
  if (sessionStorage.getItem(TOKEN)) url.searchParams.set("ticket", (await post("stream-tickets")).ticket);
  return url;
}

/**
 * The answer, or an error with a message for the operator: that of the service (RFC 9457) if there is one.
 * @param {URL} url @param {RequestInit} options
 */
async function answer(url, options) {
  return answered(await exchange(url, options));
}

/** @param {Response} response */
async function answered(response) {
  if (response.status === 401) askForToken();
  const value = parsed(await bodyOf(response));
  if (!response.ok) {
    const detail = value?.detail ?? value?.title;
    throw new Error(`HTTP ${response.status}${detail ? `: ${detail}` : ""}`);
  }
  if (value === undefined) throw new Error("the answer is not JSON");
  return value;
}

/** @param {URL} url @param {RequestInit} options */
const exchange = (url, options) =>
  inTime(fetch(url, { ...options, headers: { ...headers(), ...options.headers }, signal: AbortSignal.timeout(LONGEST_ANSWER_MS) }));

/** @param {Response} response */
const bodyOf = (response) => inTime(response.text());

/** Replaces a browser's message about a connection by one for the operator. @template T @param {Promise<T>} promise */
async function inTime(promise) {
  try {
    return await promise;
  } catch (error) {
    throw new Error(error.name === "TimeoutError" ? `no answer within ${LONGEST_ANSWER_MS / 1000} s` : "no answer");
  }
}

/** Parsed JSON; undefined if the text is not JSON. @param {string} text */
function parsed(text) {
  try {
    return JSON.parse(text);
  } catch {
    return undefined;
  }
}

/**
 * A list in an answer. An answer without it is an error, not an empty list.
 * @template {string} Name @template {{ [name in Name]: unknown[] }} Value
 * @param {Value} value @param {Name} name
 */
export function list(value, name) {
  if (!Array.isArray(value?.[name])) throw new Error(`the answer has no list of ${name}`);
  return value[name];
}

/** @type {EventName[]} */
const EVENTS = ["snapshot", "tracks", "ended", "sensor", "integrity", "alert", "heartbeat", "resync", "closed"];
const FIRST_WAIT_MS = 1000;
const LONGEST_WAIT_MS = 15000;
const DEAD_AFTER_MS = 10000; // the service sends a heartbeat every second

/** The stream of events. It reconnects by itself, because the browser's own retry gives up for good after an HTTP error. */
export class Stream {
  /**
   * `asked()` returns the picture `at` ("lagged" or "now") and the length of its trails, `trailS`. `on` has a function for each
   * event, `opened`, and `failed` with the seconds until the next attempt and the cause.
   * @param {() => StreamWish} asked @param {StreamHandlers} on
   */
  constructor(asked, on) {
    this.asked = asked;
    this.on = on;
    this.wait = FIRST_WAIT_MS;
    /** @type {EventSource | null} */
    this.source = null;
    this.heard = 0; // on the page's monotonic clock
    this.opening = 0; // number of the attempt: results of earlier attempts are ignored
    this.open();
    setInterval(() => {
      // A connection whose other end has vanished stays open without data.
      if (this.source && performance.now() - this.heard > DEAD_AFTER_MS) this.again("nothing came for 10 s");
    }, 1000);
  }

  /** Restarts the stream after other data were requested. */
  reopen() {
    this.close();
    this.open();
  }

  close() {
    this.opening += 1;
    clearTimeout(this.waiting);
    this.source?.close();
    this.source = null;
  }

  async open() {
    this.heard = performance.now();
    clearTimeout(this.waiting);
    const opening = ++this.opening;
    let source;
    try {
      source = new EventSource(await streamAddress(this.asked()));
    } catch (error) {
      return opening === this.opening && this.again(error.message);
    }
    if (opening !== this.opening) return source.close(); // another attempt was started meanwhile
    this.source = source;
    source.onopen = () => this.on.opened();
    source.onerror = () => this.again("no connection to the stream");
    for (const name of EVENTS) source.addEventListener(name, (event) => this.take(name, event.data));
  }

  /**
   * After an event that cannot be processed the state is unknown, so a new stream starts with a snapshot.
   * @param {EventName} name @param {string} data
   */
  take(name, data) {
    this.heard = performance.now();
    try {
      const value = JSON.parse(data);
      if (name === "closed") return this.again(value.reason);
      /** @type {(data: unknown) => void} */ (this.on[name])(value);
    } catch (error) {
      console.error(error);
      return this.again(`an event "${name}" could not be read`);
    }
    if (name === "heartbeat") this.wait = FIRST_WAIT_MS; // it worked for a second
  }

  /** @param {string} why */
  again(why) {
    this.source?.close();
    this.source = null;
    this.on.failed(this.wait / 1000, why);
    this.waiting = setTimeout(() => this.open(), this.wait * (0.8 + 0.4 * Math.random()));
    this.wait = Math.min(this.wait * 2, LONGEST_WAIT_MS);
  }
}
