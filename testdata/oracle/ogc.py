#!/usr/bin/env python3
"""Compares OGC API - Features of the service with what GDAL's client reads (ogr2ogr, package gdal-bin).

ogc.py BINARY [--seconds 30]: serves the bundled flight `crossing`, pauses it after these seconds, and compares every track.
"""

import argparse
import json
import pathlib
import socket
import subprocess
import tempfile
import time
import urllib.request


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("binary")
    parser.add_argument("--seconds", type=float, default=30.0)
    arguments = parser.parse_args()
    flight = pathlib.Path(__file__).parent.parent / "conformance" / "crossing"
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        base = f"http://127.0.0.1:{free.getsockname()[1]}"
    command = [arguments.binary, "replay", flight / "capture.pcap", "--config", flight / "site.toml", "--serve"]
    service = subprocess.Popen([*command, "--http", base.rsplit(":", 1)[1]], stderr=subprocess.DEVNULL)
    try:
        while True:
            try:
                urllib.request.urlopen(base + "/healthz")
                break
            except OSError:
                time.sleep(0.2)
        time.sleep(arguments.seconds)
        urllib.request.urlopen(urllib.request.Request(base + "/api/v1/replay/pause", method="POST"))
        time.sleep(0.5)
        own = json.load(urllib.request.urlopen(base + "/api/v1/tracks"))["features"]
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "tracks.geojson"
            subprocess.run(["ogr2ogr", "-f", "GeoJSON", file, f"OAPIF:{base}/ogc", "tracks"], check=True)
            read = json.loads(file.read_text())["features"]
    finally:
        service.terminate()
        service.wait()
    own = {feature["id"]: feature for feature in own}
    read = {feature["properties"]["id"]: feature for feature in read}
    assert own and own.keys() == read.keys(), (own.keys(), read.keys())
    furthest, values = 0.0, 0
    for track, feature in own.items():
        places = zip(feature["geometry"]["coordinates"], read[track]["geometry"]["coordinates"])
        furthest = max(furthest, *(abs(a - b) for a, b in places))
        for key, value in feature["properties"].items():
            # GDAL gives nested values as text, and writes times in another form.
            if isinstance(value, (dict, list)) or key.endswith("time"):
                continue
            assert read[track]["properties"][key] == value, (track, key, value, read[track]["properties"][key])
            values += 1
    print(f"{len(own)} tracks, {values} values, no difference; coordinates differ by at most {furthest:.1e}")


if __name__ == "__main__":
    main()
