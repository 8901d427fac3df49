// The service's HTTP interface. Addresses are relative, so that the page works behind a proxy's path too.

const address = (path) => new URL(`api/v1/${path}`, document.baseURI);

// A service on the network asks for a token. It is kept for this tab alone, and gone with it.
const TOKEN = "utm-fusion-token";
let askForToken = () => {};
export const onUnauthorized = (ask) => (askForToken = ask);
export const setToken = (token) => sessionStorage.setItem(TOKEN, token);

export const TRAIL_S = 60;
const LONGEST_ANSWER_MS = 10000;

function headers() {
  const token = sessionStorage.getItem(TOKEN);
  return { accept: "application/json", ...(token ? { authorization: `Bearer ${token}` } : {}) };
}

export async function get(path) {
  return answer(await fetch(address(path), { headers: headers(), signal: AbortSignal.timeout(LONGEST_ANSWER_MS) }));
}

export async function post(path, parameters = {}) {
  const url = address(path);
  for (const [name, value] of Object.entries(parameters)) url.searchParams.set(name, value);
  return answer(await fetch(url, { method: "POST", headers: headers() }));
}

/** An EventSource cannot send a header: with a token, a short-lived ticket goes into its address. */
async function streamAddress() {
  const url = address("stream");
  url.searchParams.set("trail_s", TRAIL_S); // trails are there at once
  if (sessionStorage.getItem(TOKEN)) url.searchParams.set("ticket", (await post("stream-tickets")).ticket);
  return url;
}

/** What was answered; an error carries the service's own words (RFC 9457). */
async function answer(response) {
  const text = await response.text();
  const value = text && parsed(text);
  if (response.status === 401) askForToken();
  if (!response.ok) throw new Error(value?.detail ?? value?.title ?? `${response.status} ${response.statusText}`);
  return value ?? {};
}

function parsed(text) {
  try {
    return JSON.parse(text);
  } catch {
    return null;
  }
}

const EVENTS = ["snapshot", "tracks", "ended", "sensor", "alert", "heartbeat", "resync"];
const FIRST_WAIT_MS = 1000;
const LONGEST_WAIT_MS = 15000;
const DEAD_AFTER_MS = 10000; // the service sends a heartbeat each second

/** The stream of events. It comes back by itself: the browser's own retry gives up for good on an HTTP error. */
export class Stream {
  /** `on` has a function for each event, `opened`, and `failed` with the seconds until the next attempt. */
  constructor(on) {
    this.on = on;
    this.wait = FIRST_WAIT_MS;
    this.source = null;
    this.open();
    setInterval(() => {
      // A connection whose other end has vanished stays open in silence.
      if (this.source && performance.now() - this.heard > DEAD_AFTER_MS) this.again();
    }, 1000);
  }

  async open() {
    this.heard = performance.now();
    let source;
    try {
      source = new EventSource(await streamAddress());
    } catch {
      return this.again();
    }
    this.source = source;
    source.onopen = () => {
      this.wait = FIRST_WAIT_MS;
      this.on.opened();
    };
    source.onerror = () => this.again();
    for (const name of EVENTS) {
      source.addEventListener(name, (event) => {
        this.heard = performance.now();
        const value = parsed(event.data);
        if (value) this.on[name](value);
      });
    }
  }

  again() {
    this.source?.close();
    this.source = null;
    this.on.failed(this.wait / 1000);
    setTimeout(() => this.open(), this.wait * (0.8 + 0.4 * Math.random()));
    this.wait = Math.min(this.wait * 2, LONGEST_WAIT_MS);
  }
}
