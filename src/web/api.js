// The service's HTTP interface. Addresses are relative, so that the page works behind a proxy's path too.

const address = (path) => new URL(`api/v1/${path}`, document.baseURI);

// A service on the network asks for a token. It is kept for this tab alone, and gone with it.
const TOKEN = "utm-fusion-token";
let askForToken = () => {};
export const onUnauthorized = (ask) => (askForToken = ask);
export const askForAnother = () => askForToken();
export const setToken = (token) => sessionStorage.setItem(TOKEN, token);
export const hasToken = () => sessionStorage.getItem(TOKEN) !== null;

const UPDATE_MS = 1000; // of 430 tracks 0.4 Mbit/s come; each slot would be 1.5
const LONGEST_ANSWER_MS = 10000;

function headers() {
  const token = sessionStorage.getItem(TOKEN);
  return { accept: "application/json", ...(token ? { authorization: `Bearer ${token}` } : {}) };
}

export const get = (path) => answer(address(path), {});

/** An answer that is no text. */
export async function getOctets(path) {
  const response = await exchange(address(path), {});
  if (!response.ok) return answered(response); // a problem, in words
  return new Uint8Array(await inTime(response.arrayBuffer()));
}

/** `value` goes into the body, as JSON. */
export function post(path, parameters = {}, value = null) {
  const url = address(path);
  for (const [name, value] of Object.entries(parameters)) url.searchParams.set(name, value);
  const body = value === null ? {} : { body: JSON.stringify(value), headers: { "content-type": "application/json" } };
  return answer(url, { method: "POST", ...body });
}

/** An EventSource cannot send a header: with a token, a short-lived ticket goes into its address. */
async function streamAddress({ at, trailS }) {
  const url = address("stream");
  url.searchParams.set("trail_s", trailS); // trails are there at once
  url.searchParams.set("interval_ms", UPDATE_MS);
  if (at !== "lagged") url.searchParams.set("at", at);
  if (sessionStorage.getItem(TOKEN)) url.searchParams.set("ticket", (await post("stream-tickets")).ticket);
  return url;
}

/** What was answered, or an error with words for the operator: the service's own (RFC 9457) where it has some. */
async function answer(url, options) {
  return answered(await exchange(url, options));
}

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

const exchange = (url, options) =>
  inTime(fetch(url, { ...options, headers: { ...headers(), ...options.headers }, signal: AbortSignal.timeout(LONGEST_ANSWER_MS) }));

const bodyOf = (response) => inTime(response.text());

/** What a browser says of a connection is in no words for an operator. */
async function inTime(promise) {
  try {
    return await promise;
  } catch (error) {
    throw new Error(error.name === "TimeoutError" ? `no answer within ${LONGEST_ANSWER_MS / 1000} s` : "no answer");
  }
}

/** Undefined where it is not JSON. */
function parsed(text) {
  try {
    return JSON.parse(text);
  } catch {
    return undefined;
  }
}

/** A list in an answer. One without it is another answer than was asked for, not an empty list. */
export function list(value, name) {
  if (!Array.isArray(value?.[name])) throw new Error(`the answer has no list of ${name}`);
  return value[name];
}

const EVENTS = ["snapshot", "tracks", "ended", "sensor", "integrity", "alert", "heartbeat", "resync", "closed"];
const FIRST_WAIT_MS = 1000;
const LONGEST_WAIT_MS = 15000;
const DEAD_AFTER_MS = 10000; // the service sends a heartbeat each second

/** The stream of events. It comes back by itself: the browser's own retry gives up for good on an HTTP error. */
export class Stream {
  /**
   * `asked()`: which picture, `at` ("lagged" or "now"), and how long its trails are, `trailS`. `on` has a function for each
   * event, `opened`, and `failed` with the seconds until the next attempt and the cause.
   */
  constructor(asked, on) {
    [this.asked, this.on] = [asked, on];
    this.wait = FIRST_WAIT_MS;
    this.source = null;
    this.opening = 0; // counts: what an earlier attempt comes to does not matter
    this.open();
    setInterval(() => {
      // A connection whose other end has vanished stays open in silence.
      if (this.source && performance.now() - this.heard > DEAD_AFTER_MS) this.again("nothing came for 10 s");
    }, 1000);
  }

  /** What is asked for has changed, or is wanted anew. */
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
    if (opening !== this.opening) return source.close(); // another one was asked for meanwhile
    this.source = source;
    source.onopen = () => this.on.opened();
    source.onerror = () => this.again("no connection to the stream");
    for (const name of EVENTS) source.addEventListener(name, (event) => this.take(name, event.data));
  }

  /** After an event that cannot be taken nobody knows what is true: a new stream begins with everything. */
  take(name, data) {
    this.heard = performance.now();
    try {
      const value = JSON.parse(data);
      if (name === "closed") return this.again(value.reason);
      this.on[name](value);
    } catch (error) {
      console.error(error);
      return this.again(`an event "${name}" could not be read`);
    }
    if (name === "heartbeat") this.wait = FIRST_WAIT_MS; // a second of it was good
  }

  again(why) {
    this.source?.close();
    this.source = null;
    this.on.failed(this.wait / 1000, why);
    this.waiting = setTimeout(() => this.open(), this.wait * (0.8 + 0.4 * Math.random()));
    this.wait = Math.min(this.wait * 2, LONGEST_WAIT_MS);
  }
}
