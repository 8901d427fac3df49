#!/usr/bin/env python3
"""Holds the program against `reference.py` on random sites.

    python3 compare.py PROGRAM SEED [SEED ...]

PROGRAM is a built `utm-fusion`. For every seed `scenario/random_site.py` makes a site, both compute it, and the points are compared
in order: slot, kind, number, radar track, transponder, and position. Ends with an error where anything differs.
"""

import csv
import math
import os
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
TOLERANCE_M = 0.001


def rows(path, kind):
    """(slot, kind, number, radar track, transponder) and (latitude, longitude, altitude or None) of each point."""
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            slot = math.floor(float(row["time"]) * 4)
            number = row.get("number") or row["track_number"]
            altitude = float(row["alt_msl"]) if row["alt_msl"] else None
            yield ((slot, row[kind], number, row["radar_track"], row["transponder"]),
                   (float(row["lat"]), float(row["lon"]), altitude))


def distance(a, b):
    """The larger of horizontal and vertical distance, metres; infinite where only one has a height."""
    if (a[2] is None) != (b[2] is None):
        return math.inf
    north = math.radians(a[0] - b[0]) * 6_371_000
    east = math.radians(a[1] - b[1]) * 6_371_000 * math.cos(math.radians(a[0]))
    return max(math.hypot(north, east), abs(a[2] - b[2]) if a[2] is not None else 0.0)


def compare(program, seed, folder):
    capture, site = os.path.join(folder, "capture.pcap"), os.path.join(folder, "site.toml")
    expected, got = os.path.join(folder, "expected.csv"), os.path.join(folder, "got.csv")

    def run(*command):
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    run(sys.executable, "-B", os.path.join(HERE, "../scenario/random_site.py"), str(seed), folder)
    run(sys.executable, "-B", os.path.join(HERE, "reference.py"), capture, "--config", site, "-o", expected)
    run(program, "replay", capture, "--config", site, "-o", got)
    theirs, ours = list(rows(expected, "kind")), list(rows(got, "source"))
    same = [key for key, _ in theirs] == [key for key, _ in ours]
    largest = max(distance(a[1], b[1]) for a, b in zip(theirs, ours)) if same and theirs else math.inf
    print(f"seed {seed}: {len(theirs)} points, {'the same' if same else 'NOT the same'}, largest difference {1000 * largest:.2f} mm")
    return len(theirs), largest


def main():
    program, *seeds = sys.argv[1:]
    results = []
    for seed in seeds:
        with tempfile.TemporaryDirectory() as folder:
            results.append(compare(program, int(seed), folder))
    largest = max(difference for _, difference in results)
    print(f"{len(results)} sites, {sum(points for points, _ in results)} points, largest difference {1000 * largest:.2f} mm")
    sys.exit(largest > TOLERANCE_M)


if __name__ == "__main__":
    main()
