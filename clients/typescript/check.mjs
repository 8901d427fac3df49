// Tries everything that the client does on a service with traffic: node check.mjs http://127.0.0.1:8080
import assert from "node:assert/strict";
import { ApiError, Client } from "./utm-fusion.js";

const client = new Client(process.argv[2]);
assert.match((await client.get("/api/v1/info")).version, /^\d+\.\d+\.\d+/);

const ids = [];
for await (const track of client.tracks({ limit: 2 })) ids.push(track.id);
assert.ok(ids.length > 2 && new Set(ids).size === ids.length, `${ids}`);
const fused = await client.get("/api/v1/tracks", { source: ["fused", "transponder"] });
assert.ok(fused.features.every((track) => track.properties.source !== "radar"));
const [{ id }] = fused.features;
assert.equal((await client.get("/api/v1/tracks/{id}", { id })).id, id);

const refused = await client.get("/api/v1/tracks", { limit: 0 }).catch((error) => error);
assert.ok(refused instanceof ApiError && refused.problem.status === 400 && refused.problem.parameter === "limit");
const { ticket } = await client.post("/api/v1/stream-tickets");
assert.ok(ticket.length > 10);

let last;
let count = 0;
for await (const event of client.events()) {
  if (count === 0) assert.equal(event.event, "snapshot");
  last = event;
  if (++count === 8) break;
}
for await (const event of client.events({}, { lastEventId: last.id })) {
  assert.notEqual(event.event, "snapshot", "it goes on where it was");
  break;
}

const stop = new AbortController();
let picture;
for await (const { tracks, event } of client.pictures({ interval_ms: 500 }, { signal: stop.signal })) {
  if (event.event !== "snapshot" && event.event !== "tracks") continue;
  picture ??= await client.get("/api/v1/tracks");
  if (event.data.seq < picture.seq) continue;
  // Two seconds of grace: what was there a moment ago has not ended yet.
  for (const track of picture.features) assert.ok(tracks.has(track.id), track.id);
  assert.ok(tracks.size >= picture.numberReturned);
  stop.abort();
}
await assert.rejects(async () => {
  for await (const event of client.events({ bbox: "nowhere" })) assert.fail(event.event);
}, ApiError);
console.log("ok");
