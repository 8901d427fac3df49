"""Tries everything that the client does on a service with traffic: python3 check.py http://127.0.0.1:8080"""

import itertools
import sys

from utm_fusion_client import ApiError, Client

client = Client(sys.argv[1])
assert client.get("/api/v1/info")["version"].count(".") == 2

ids = [track["id"] for track in client.tracks(limit=2)]
assert len(ids) > 2 and len(set(ids)) == len(ids), ids
fused = client.get("/api/v1/tracks", source=["fused", "transponder"])
assert all(track["properties"]["source"] != "radar" for track in fused["features"])
one = fused["features"][0]["id"]
assert client.get("/api/v1/tracks/{id}", id=one)["id"] == one

try:
    client.get("/api/v1/tracks", limit=0)
    raise AssertionError("this is refused")
except ApiError as error:
    assert error.problem["status"] == 400 and error.problem["parameter"] == "limit", error
assert len(client.post("/api/v1/stream-tickets")["ticket"]) > 10

events = list(itertools.islice(client.events(), 8))
assert events[0]["event"] == "snapshot" and all(event["event"] != "snapshot" for event in events[1:])
again = next(client.events(last_event_id=events[-1]["id"]))
assert again["event"] != "snapshot", "it goes on where it was"

picture = client.get("/api/v1/tracks")
for tracks in itertools.islice(client.pictures(interval_ms=500), 4):
    assert tracks and all(track["id"] == key for key, track in tracks.items())
# Two seconds of grace: what was there a moment ago has not ended yet.
assert any(track["id"] in tracks for track in picture["features"])
print("ok")
