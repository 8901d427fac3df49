"""Observations (ASTM F3623) against Flight Blender's own schemas.

    git clone https://github.com/openutm/flight-blender
    python3 testdata/oracle/flight_blender.py PROGRAM flight-blender [--scenario FILE] [--seconds 30]

runs the live service (PROGRAM run) on a simulated flight (PROGRAM simulate --udp) with a sink that posts to this script, which
answers as Flight Blender does: the session has to be a UUID, the body what its pydantic model of a request takes, and each
observation what its marshmallow schema and, as its tasks read it, its dataclass take. The observations are held against the
tracks that the HTTP interface shows of the same time. Nothing leaves this machine.

    pip install pydantic marshmallow dacite
"""

import argparse
import datetime
import http.server
import importlib.util
import json
import pathlib
import subprocess
import tempfile
import threading
import time
import urllib.request
import uuid

import dacite

PORT, HTTP_PORT, TOKEN = 28091, 28090, "a.bearer.token"

parser = argparse.ArgumentParser()
parser.add_argument("program")
parser.add_argument("checkout", type=pathlib.Path)
parser.add_argument("--scenario", default="config/scenarios/crossing.toml")
parser.add_argument("--seconds", type=float, default=30)
arguments = parser.parse_args()

# The file of its schemas alone: the package needs a database.
file = arguments.checkout / "src/flight_blender/schemas/flight_feed.py"
spec = importlib.util.spec_from_file_location("flight_feed", file)
flight_feed = importlib.util.module_from_spec(spec)
spec.loader.exec_module(flight_feed)

taken, refused, tracks = [], [], {}


class FlightBlender(http.server.BaseHTTPRequestHandler):
    def do_POST(self):
        body = self.rfile.read(int(self.headers["Content-Length"]))
        try:
            assert self.headers["Authorization"] == f"Bearer {TOKEN}"
            assert self.headers["Content-Type"] == "application/json"
            root, session = self.path.rsplit("/", 1)
            assert root == "/flight_stream/set_air_traffic", self.path
            uuid.UUID(session)
            request = flight_feed.ObservationRequest.model_validate_json(body, strict=True)
            raw = json.loads(body)["observations"]
            flight_feed.ObservationSchema(many=True).load(raw)
            for observation in request.observations:
                data = {**observation.model_dump(), "session_id": session}
                taken.append(dacite.from_dict(flight_feed.SingleAirtrafficObservation, data))
            status = 201
        except Exception as error:
            refused.append((error, body))
            status = 422
        self.send_response(status)
        self.send_header("Content-Length", "0")
        self.end_headers()

    def log_message(self, *_):
        pass


def watch(ends):
    while not ends.is_set():
        try:
            with urllib.request.urlopen(f"http://127.0.0.1:{HTTP_PORT}/api/v1/tracks", timeout=2) as answer:
                for feature in json.load(answer)["features"]:
                    tracks[feature["properties"]["id"], feature["properties"]["time"]] = feature["properties"]
        except OSError:
            pass
        time.sleep(0.05)


def fly(folder):
    simulate = [arguments.program, "simulate", arguments.scenario]
    subprocess.run([*simulate, "--out", str(folder / "out")], check=True, capture_output=True)
    site = (folder / "out" / "site.toml").read_text().replace("\nf3623 = []\n", "\n")
    site += f"""
[[output.f3623]]
id = "blender"
url = "http://127.0.0.1:{PORT}/flight_stream/set_air_traffic/{uuid.uuid4()}"
token_file = "token"
"""
    (folder / "site.toml").write_text(site)
    (folder / "token").write_text(TOKEN + "\n")
    state = {"UTM_FUSION__STATE__DIR": str(folder / "state"), "UTM_FUSION__HTTP__LISTEN": f"127.0.0.1:{HTTP_PORT}"}
    server = http.server.ThreadingHTTPServer(("127.0.0.1", PORT), FlightBlender)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    ends = threading.Event()
    threading.Thread(target=watch, args=[ends], daemon=True).start()
    with open(folder / "run.log", "w") as log:
        run = [arguments.program, "run", "--config", str(folder / "site.toml")]
        service = subprocess.Popen(run, stderr=log, env=state)
    flown = subprocess.Popen([*simulate, "--udp"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    time.sleep(arguments.seconds)
    flown.terminate()
    service.terminate()
    service.wait(10)
    ends.set()
    server.shutdown()


with tempfile.TemporaryDirectory() as name:
    fly(pathlib.Path(name))
    log = (pathlib.Path(name) / "run.log").read_text()
assert not refused, refused[0]
compared, sources = 0, {}
for observation in taken:
    sources[observation.traffic_source] = sources.get(observation.traffic_source, 0) + 1
    track = tracks.get((observation.icao_address, observation.metadata["time"]))
    if track is None:
        continue
    compared += 1
    assert abs(observation.lat_dd - track["lat"]) < 1e-6 and abs(observation.lon_dd - track["lng"]) < 1e-6, track
    assert abs(observation.altitude_mm - track["alt"] * 1000) <= 1, track
    moment = datetime.datetime.fromisoformat(track["time"])
    assert observation.timestamp == round(moment.timestamp() * 1000), (observation, track)
print(f"schemas     {len(taken)} observations, none refused; by traffic_source {sources}")
print(f"interface   {compared} of them beside the tracks of the same time: no value differs")
assert compared > 20, log
