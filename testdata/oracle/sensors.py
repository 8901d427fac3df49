#!/usr/bin/env python3
"""What crewed aircraft, Remote ID and made-up identities do to the picture: figures of docs/EVALUATION.md.

    cargo build --release && python3 testdata/oracle/sensors.py target/release/utm-fusion

Simulates each scenario of config/scenarios with each seed, replays it, and holds the output against the truth.
"""

import argparse
import collections
import csv
import json
import pathlib
import statistics
import subprocess
import tempfile

SCENARIOS = pathlib.Path(__file__).resolve().parents[2] / "config" / "scenarios"


class Flight:
    """A simulated flight and what the program makes of it."""

    def __init__(self, program, scenario, seed, folder):
        self.folder = folder / f"{scenario}-{seed}"
        self.program = program
        self.run("simulate", SCENARIOS / f"{scenario}.toml", "--out", self.folder, "--seed", seed)
        self.output = self.folder / "out.ndjson"
        self.run("replay", self.folder / "capture.pcap", "--config", self.folder / "site.toml", "-o", self.output)

    def run(self, *arguments):
        command = [self.program, *map(str, arguments)]
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout

    def evaluated(self):
        """`evaluate --json`."""
        where = {"truth": "truth.csv", "labels": "labels.csv", "config": "site.toml", "capture": "capture.pcap"}
        options = [part for name, file in where.items() for part in (f"--{name}", self.folder / file)]
        return json.loads(self.run("evaluate", self.output, *options, "--json"))

    def tracks(self):
        """Each track of each slot."""
        with open(self.output, encoding="utf-8") as lines:
            yield from map(json.loads, lines)

    def rows(self, file):
        """Those of a table, where there is one."""
        if not (self.folder / file).exists():
            return []
        with open(self.folder / file, encoding="utf-8", newline="") as rows:
            return list(csv.DictReader(rows))

    def classes(self):
        """Class by serial number, in CAT129 or Remote ID."""
        return {row[key]: row["class"] for row in self.rows("classes.csv") for key in ("serial", "remote_id") if row[key]}

    def attacked(self):
        """The serial numbers of those that lie, or are jammed, at some time; the simulator's count from 1."""
        return {f"{row['number']:0>12}" for row in self.rows("attacks.csv")}


def who(track):
    """The name of its identity."""
    return (track.get("uas_id") or {}).get("serial_number") or (track.get("aircraft") or {}).get("icao24")


def crewed(program, seeds, folder):
    """Crewed aircraft beside `crossing`: are they there, and is anything else otherwise?"""
    updates, changed = [], []
    for seed in seeds:
        alone, beside = (Flight(program, scenario, seed, folder) for scenario in ("crossing", "crossing-crewed"))
        drones = beside.evaluated()["drones"]
        updates += [of["fused"]["pu_percent"] for of in drones if of["id"][0] in "ACHX"]
        places = lambda flight: {
            tuple(track.get(key) for key in ("time", "id", "source", "lat", "lng", "alt_msl")) for track in flight.tracks()
        }
        before, after = places(alone), places(beside)
        changed.append((len(before), len(before - after)))
    print(f"crossing-crewed: probability of update of {len(updates)} crewed aircraft: least {min(updates):.1f} %, "
          f"median {statistics.median(updates):.1f} %")
    print("crossing-crewed: points of `crossing`, and those of them that are not the same beside crewed aircraft: "
          + ", ".join(f"{all_}: {other}" for all_, other in changed))


def remote_id(program, seeds, folder):
    """Drones with Remote ID only, lossy, beside a radar."""
    rows = []
    for seed in seeds:
        evaluated = Flight(program, "remote-id", seed, folder).evaluated()
        fused, alone = evaluated["fused"]["all"], evaluated["transponder"]["all"]
        rows.append((fused["pu_percent"], alone["pu_percent"], fused["eposh"]["mean_m"], alone["eposh"]["mean_m"],
                     fused["eposv"]["mean_m"]))
    pu, pu_alone, error, error_alone, vertical = (statistics.mean(column) for column in zip(*rows))
    print(f"remote-id: probability of update {pu:.1f} % (Remote ID alone {pu_alone:.1f} %), least {min(row[0] for row in rows):.1f} %; "
          f"error over ground {error:.2f} m (alone {error_alone:.2f} m), in height {vertical:.2f} m")


def verified(program, seeds, folder):
    """Twenty identities at once that do not exist, and those that do and do not lie: who is verified?"""
    for scenario in ("fakes", "event", "crossing", "spoof"):
        points, of_these = collections.Counter(), collections.Counter()
        for seed in seeds:
            flight = Flight(program, scenario, seed, folder)
            classes, liars = flight.classes(), flight.attacked()
            for track in flight.tracks():
                kind = classes.get(who(track)) if classes else "unmanned"
                if track.get("integrity") and kind in ("unmanned", "fake") and who(track) not in liars:
                    points[kind, seed, who(track)] += 1
                    of_these[kind, seed, who(track)] += track["integrity"] == "verified"
        for kind in ("unmanned", "fake"):
            its = [identity for identity in points if identity[0] == kind]
            if its:
                share = sum(of_these[identity] for identity in its) / sum(points[identity] for identity in its)
                print(f"{scenario}: {kind}: {sum(of_these[identity] > 0 for identity in its)} of {len(its)} ever verified, "
                      f"{100 * share:.1f} % of their points")


def event(program, seeds, folder):
    """All sensors at once: is each identity one aircraft?"""
    for seed in seeds:
        ids = collections.defaultdict(set)
        for track in Flight(program, "event", seed, folder).tracks():
            if who(track):
                ids[who(track)].add(track["id"])
        several = sum(len(of) > 1 for of in ids.values())
        print(f"event {seed}: {len(ids)} identities, {several} with more than one track")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--first-seed", type=int, default=1001)
    parser.add_argument("--seeds", type=int, default=5)
    arguments = parser.parse_args()
    seeds = range(arguments.first_seed, arguments.first_seed + arguments.seeds)
    with tempfile.TemporaryDirectory() as folder:
        for figure in (crewed, remote_id, verified, event):
            figure(arguments.program, seeds, pathlib.Path(folder))


if __name__ == "__main__":
    main()
