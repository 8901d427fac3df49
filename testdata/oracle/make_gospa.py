#!/usr/bin/env python3
"""Writes gospa.csv: random truths and points with their GOSPA (p = 2, alpha = 2) by Stone Soup.

    pip install stonesoup==1.9.1 && python3 make_gospa.py gospa.csv
"""

import random
import sys
from datetime import datetime

import numpy as np
from stonesoup.metricgenerator.ospametric import GOSPAMetric
from stonesoup.types.state import State

SEED = 20260614
CASES = 100


def states(points):
    now = datetime(2026, 1, 1)
    return [State(np.array([[x] for x in point]), timestamp=now) for point in points]


def by_stonesoup(truths, points, cut_off):
    if not truths and not points:
        return 0.0, 0.0, 0.0, 0.0    # it asks for the time of at least one
    metric = GOSPAMetric(p=2, c=cut_off)
    # The first of its sets is what is measured, the second the truth.
    metric, _ = metric.compute_gospa_metric(states(points), states(truths))
    value = metric.value
    # Its parts are costs, some with a minus: the sum of squares of the pairs, and c^2 / 2 for each of the others.
    half = cut_off ** 2 / 2
    return value["distance"], abs(value["localisation"]), abs(value["missed"]) / half, abs(value["false"]) / half


def sets(rng, case):
    """Truths, points near some of them, and points anywhere; a crowd within the cut-off in every third case."""
    dimensions = rng.choice([2, 3])
    width = [400.0, 120.0, 40.0][case % 3]
    anywhere = lambda: [rng.uniform(-width, width) for _ in range(dimensions)]
    truths = [anywhere() for _ in range(rng.randint(0, 12))]
    noise = rng.choice([1.0, 10.0, 40.0])
    points = [[x + rng.gauss(0, noise) for x in truth] for truth in truths if rng.random() < 0.8]
    points = (points + [anywhere() for _ in range(rng.randint(0, 6))])[:12]
    rng.shuffle(points)
    return truths, points


def text(points):
    return ";".join(" ".join(repr(x) for x in point) for point in points)


def main():
    rng = random.Random(SEED)
    with open(sys.argv[1], "w", encoding="ascii") as out:
        out.write(f"# GOSPA (p = 2, alpha = 2) by Stone Soup 1.9.1, seed {SEED}\n")
        out.write("case,cut_off,truths,points,gospa,localisation,missed,false\n")
        for case in range(CASES):
            truths, points = sets(rng, case)
            cut_off = rng.choice([50.0, 50.0, 20.0])
            values = by_stonesoup(truths, points, cut_off)
            numbers = ",".join(repr(float(value)) for value in values)
            out.write(f"{case},{cut_off},{text(truths)},{text(points)},{numbers}\n")


if __name__ == "__main__":
    main()
