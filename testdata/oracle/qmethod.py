#!/usr/bin/env python3
"""Writes qmethod.csv: random unit vectors, their weights, and the rotation that SciPy finds between them.

    pip install numpy scipy && python3 qmethod.py qmethod.csv
"""

import sys

import numpy as np
from scipy.spatial.transform import Rotation

SEED = 20260712
CASES = 100


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def case(rng, index):
    """Drones low over the horizon in every second case, anywhere in the others; any turn, or one of some degrees."""
    count = rng.integers(3, 40)
    reference = rng.normal(size=(count, 3))
    if index % 2 == 0:
        reference[:, 2] *= 0.1
    reference = unit(reference)
    turn = Rotation.random(rng=rng) if index % 3 == 0 else Rotation.from_rotvec(rng.normal(0, 0.05, 3))
    noise = [0.0, 0.003, 0.03][index // 2 % 3]
    measured = unit(turn.apply(reference) + rng.normal(0, noise, (count, 3)))
    weights = rng.uniform(0.1, 5.0, count) * 10.0 ** rng.integers(-2, 5)
    return weights, measured, reference


def text(numbers):
    return " ".join(repr(float(number)) for number in np.ravel(numbers))


def main():
    rng = np.random.default_rng(SEED)
    with open(sys.argv[1], "w", encoding="ascii") as out:
        out.write(f"# Rotation.align_vectors of SciPy 1.17.1, seed {SEED}\n")
        out.write("case,weights,measured,reference,rotation,loss\n")
        for index in range(CASES):
            weights, measured, reference = case(rng, index)
            found, _ = Rotation.align_vectors(measured, reference, weights=weights)
            loss = np.sum(weights * np.sum((measured - found.apply(reference)) ** 2, axis=1)) / 2
            fields = (weights, measured, reference, found.as_matrix(), loss)
            out.write(f"{index}," + ",".join(text(field) for field in fields) + "\n")


if __name__ == "__main__":
    main()
