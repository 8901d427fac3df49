// A client of the air picture, for browsers and Node.js 18 and later; it needs nothing else. utm-fusion.d.ts has its types.

/** What goes on before a connection that was lost is tried again: at first, and at most, milliseconds. */
const AGAIN_MS = [500, 15_000];
/** A stream has a heartbeat each second; one that says nothing for so long is lost, milliseconds. */
const SILENT_MS = 10_000;

/** The service does not do what was asked; `problem` is what it says (RFC 9457). */
export class ApiError extends Error {
  constructor(problem) {
    super(`${problem.status} ${problem.title}: ${problem.detail}`);
    this.name = "ApiError";
    this.problem = problem;
  }
}

export class Client {
  #url;
  #headers;

  /** `url` is the service's, "http://127.0.0.1:8080"; `token` is needed where the service asks for one. */
  constructor(url, { token } = {}) {
    this.#url = url.replace(/\/+$/, "");
    this.#headers = token === undefined ? {} : { authorization: `Bearer ${token}` };
  }

  /** What a path answers. What stands in braces in it is taken out of the parameters; a list is joined by commas. */
  async get(path, parameters = {}) {
    return (await this.#ask(path, parameters)).json();
  }

  /** Has something done; `body` is sent as JSON. */
  async post(path, parameters = {}, body = undefined) {
    const json = body === undefined ? {} : { headers: { "content-type": "application/json" }, body: JSON.stringify(body) };
    return (await this.#ask(path, parameters, { method: "POST", ...json })).json();
  }

  /** All tracks of the picture, `limit` at a time. */
  async *tracks(parameters = {}) {
    let after;
    do {
      const page = await this.get("/api/v1/tracks", { limit: 1000, ...parameters, ...(after === undefined ? {} : { after }) });
      yield* page.features;
      after = page.next;
    } while (after !== undefined);
  }

  /**
   * The events of the stream, one by one. A connection that is lost is made anew, and goes on behind the last event where the
   * service remembers it; else there is a snapshot. Ends with `signal`, or with the loop that reads it.
   */
  async *events(parameters = {}, { signal, lastEventId } = {}) {
    let [wait_ms] = AGAIN_MS;
    while (!signal?.aborted) {
      const lost = new AbortController();
      let timer = setTimeout(() => lost.abort(), SILENT_MS);
      const stop = () => lost.abort();
      signal?.addEventListener("abort", stop);
      try {
        const headers = lastEventId === undefined ? {} : { "last-event-id": lastEventId };
        const answer = await this.#ask("/api/v1/stream", parameters, { headers, signal: lost.signal });
        for await (const event of parsed(answer.body)) {
          clearTimeout(timer);
          timer = setTimeout(() => lost.abort(), SILENT_MS);
          [wait_ms] = AGAIN_MS;
          lastEventId = event.id;
          yield event;
        }
      } catch (error) {
        const isFinal = error instanceof ApiError && ![429, 502, 503, 504].includes(error.problem.status);
        if (isFinal) throw error;
      } finally {
        clearTimeout(timer);
        signal?.removeEventListener("abort", stop);
        lost.abort();
      }
      if (signal?.aborted) return;
      await new Promise((resolve) => setTimeout(resolve, wait_ms));
      wait_ms = Math.min(2 * wait_ms, AGAIN_MS[1]);
    }
  }

  /** The picture whenever it has changed: its tracks by id, kept up to date, and the event that changed it. */
  async *pictures(parameters = {}, options = {}) {
    const tracks = new Map();
    for await (const event of this.events(parameters, options)) {
      if (event.event === "snapshot" || event.event === "resync") tracks.clear();
      if (event.event === "snapshot" || event.event === "tracks") {
        for (const track of event.data.features) tracks.set(track.id, track);
      } else if (event.event === "ended") {
        for (const id of event.data.ids) tracks.delete(id);
      } else {
        continue;
      }
      yield { tracks, event };
    }
  }

  async #ask(path, parameters, { headers, ...options } = {}) {
    const query = new URLSearchParams();
    let filled = path;
    for (const [name, value] of Object.entries(parameters)) {
      if (value === undefined) continue;
      if (path.includes(`{${name}}`)) filled = filled.replace(`{${name}}`, encodeURIComponent(value));
      else query.set(name, Array.isArray(value) ? value.join(",") : String(value));
    }
    const search = query.size === 0 || query.toString() === "" ? "" : `?${query}`;
    const answer = await fetch(this.#url + filled + search, { ...options, headers: { ...this.#headers, ...headers } });
    if (answer.ok) return answer;
    const plain = { type: "about:blank", title: answer.statusText, status: answer.status, detail: path };
    throw new ApiError(await answer.json().catch(() => plain));
  }
}

/** Server-Sent Events as this service writes them: three lines each, and an empty one. */
async function* parsed(body) {
  const reader = body.pipeThrough(new TextDecoderStream()).getReader();
  let text = "";
  try {
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return;
      text += value;
      const events = text.split("\n\n");
      text = events.pop();
      for (const event of events) {
        const fields = Object.fromEntries(event.split("\n").map((line) => [line.slice(0, line.indexOf(":")), line.slice(line.indexOf(":") + 2)]));
        yield { event: fields.event, id: fields.id, data: JSON.parse(fields.data) };
      }
    }
  } finally {
    await reader.cancel().catch(() => undefined);
  }
}
