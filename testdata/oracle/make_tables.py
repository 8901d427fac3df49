#!/usr/bin/env python3
"""Tables to test interpolation and geodesy against: SciPy's PCHIP, PROJ's ECEF and ENU, and the radar's polar formula.

    python3 make_tables.py FOLDER

Writes pchip.csv, geodesy.csv and polar.csv into FOLDER. Seeded: the same versions of SciPy and PROJ give the same bytes.
Columns and units are described in SOURCE.md and in the comment that heads each table.
"""

import argparse
import csv
import math
import pathlib
import random

import mpmath
import numpy as np
import pyproj
import scipy
from mpmath import mpf
from pyproj import Transformer
from scipy.interpolate import PchipInterpolator

SEED = 129
mpmath.mp.dps = 40
A = mpf(6378137)
F = 1 / mpf("298.257223563")
E2 = F * (2 - F)


# --- PCHIP -----------------------------------------------------------------------------------------------------------

def hand_picked():
    """(name, times in s, values in m): one case for each branch of the method."""
    yield "two knots", [0, 2], [10, 14]
    yield "two knots: level", [0, 2], [7, 7]
    yield "two knots: far apart", [0, 24.9921875], [-300, 812.5]
    yield "straight line", [0, 1, 3, 7.5], [1, 3, 7, 16]
    yield "hovering", [0, 2, 4, 6, 8], [42.5] * 5
    yield "hovering: then off", [0, 2, 4, 6, 8], [5, 5, 5, 9, 20]
    yield "off: then hovering", [0, 2, 4, 6, 8], [20, 9, 5, 5, 5]
    yield "plateau amid a climb", [0, 2, 4, 6, 8, 10], [0, 10, 20, 20, 30, 40]
    yield "peak", [0, 2, 4], [0, 10, 0]
    yield "trough", [0, 2.5, 4], [0, -10, 5]
    yield "zigzag", [0, 2, 4, 6, 8, 10], [0, 5, -5, 5, -5, 0]
    yield "peak of two equal knots", [0, 2, 4, 6], [0, 8, 8, 0]
    yield "first end slope of the wrong sign", [0, 2, 4, 6], [0, 1, 20, 21]
    yield "first end slope limited", [0, 2, 2.5, 6], [0, 1, -30, -31]
    yield "last end slope of the wrong sign", [0, 2, 4, 6], [0, 1, 20, 21.5]
    yield "last end slope limited", [0, 3.5, 4, 6], [0, 1, 31, 30]
    yield "three knots: monotone", [0, 2, 5], [0, 1, 50]
    yield "three knots: secant zero at the start", [0, 2, 4], [3, 3, 9]
    yield "three knots: secant zero at the end", [0, 2, 4], [9, 3, 3]
    yield "long gap", [0, 2, 4, 24, 24.5], [0, 20, 40, 45, 80]
    yield "knots 1/128 s apart", [0, 1 / 128, 2, 2 + 1 / 128, 4], [0, 0.25, 12, 12.25, 20]
    yield "intervals of 1/128 s and 24 s", [0, 1 / 128, 24, 24 + 1 / 128], [5, 5.5, 900, 899]
    yield "steep step", [0, 2, 2 + 1 / 128, 4], [0, 0, 100, 100]
    yield "tiny differences", [0, 2, 4, 6], [1e5, 1e5 + 1e-6, 1e5 + 3e-6, 1e5 + 2e-6]
    yield "large values", [0, 2, 4, 6], [-9e4, 1e5, 1.1e5, 1.2e5]


def random_cases(rng, count):
    for index in range(count):
        knots = rng.randint(2, 14)
        style = rng.choice(["regular", "irregular", "extreme"])
        time, value, speed = 0.0, rng.uniform(-5000, 5000), rng.uniform(-25, 25)
        times, values = [], []
        for _ in range(knots):
            times.append(time)
            values.append(round(value, 4))
            ticks = {"regular": 256 + rng.randint(-20, 20), "irregular": rng.randint(64, 640),
                     "extreme": rng.choice([1, 2, 8, 256, 1024])}[style]
            time += ticks / 128
            speed = rng.choice([speed, speed + rng.uniform(-8, 8), -speed, 0.0])
            value += speed * ticks / 128
        yield f"{style} {index}", times, values


def pchip(rng, writer):
    writer.writerow(["case", "name", "times", "values", "at", "result"])
    cases = [*hand_picked(), *random_cases(rng, 175)]
    for number, (name, times, values) in enumerate(cases):
        curve = PchipInterpolator(times, values)
        at = {times[0], times[-1], *rng.sample(times, min(3, len(times)))}
        at |= {round(rng.uniform(times[0], times[-1]), 6) for _ in range(8)}
        at = sorted(at)
        row = [times, values, at, curve(at)]
        writer.writerow([number, name, *(" ".join(repr(float(x)) for x in column) for column in row)])


# --- geodesy ---------------------------------------------------------------------------------------------------------

def to_ecef(latitude, longitude, height):
    """Degrees and metres to ECEF, in 40 digits."""
    phi, lam = (mpmath.radians(mpf(x)) for x in (latitude, longitude))
    normal = A / mpmath.sqrt(1 - E2 * mpmath.sin(phi) ** 2)
    ground = (normal + height) * mpmath.cos(phi)
    return ground * mpmath.cos(lam), ground * mpmath.sin(lam), (normal * (1 - E2) + height) * mpmath.sin(phi)


def height_of(ecef):
    """Ellipsoidal height of a point near the ellipsoid, in 40 digits (fixed point on the latitude)."""
    x, y, z = ecef
    ground = mpmath.hypot(x, y)
    phi = mpmath.atan2(z, ground * (1 - E2))
    for _ in range(20):
        normal = A / mpmath.sqrt(1 - E2 * mpmath.sin(phi) ** 2)
        phi = mpmath.atan2(z + E2 * normal * mpmath.sin(phi), ground)
    return ground * mpmath.cos(phi) + z * mpmath.sin(phi) - A * mpmath.sqrt(1 - E2 * mpmath.sin(phi) ** 2)


def enu_to_ecef(origin, enu):
    """A point given about the origin (degrees, metres), in ECEF."""
    phi, lam = (mpmath.radians(mpf(x)) for x in origin[:2])
    (sin_phi, cos_phi), (sin_lam, cos_lam) = ((mpmath.sin(x), mpmath.cos(x)) for x in (phi, lam))
    x, y, z = to_ecef(*origin)
    e, n, u = enu
    return (x - sin_lam * e - sin_phi * cos_lam * n + cos_phi * cos_lam * u,
            y + cos_lam * e - sin_phi * sin_lam * n + cos_phi * sin_lam * u,
            z + cos_phi * n + sin_phi * u)


SITES = [(0.0, 0.0, 0.0), (0.0, 180.0, 12.0), (0.0, 90.0, 50.0), (0.0, -90.0, 2850.0), (1.35, 103.8, 20.0),
         (-33.9, 151.2, 40.0), (52.5065, -0.588, 105.0), (51.5, 5.86, 80.9), (45.0, 90.0, 1500.0),
         (-17.8, 179.99, 60.0), (-17.8, -179.99, 60.0), (65.0, -179.9999, 5.0), (69.3, 18.9, 90.0),
         (-54.8, -68.3, 30.0), (78.2, 15.6, 35.0), (89.99, 40.0, 10.0), (-89.99, -120.0, 2835.0),
         (85.0, 180.0, 0.0), (27.99, 86.93, 5364.0), (-0.0001, 36.8, 1700.0), (31.5, 35.5, -100.0)]


def geodesy(rng, writer):
    writer.writerow("lat0 lon0 h0 lat lon h x y z e n u".split())
    cart = Transformer.from_pipeline("+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad "
                                     "+step +proj=cart +ellps=WGS84")
    for site in SITES:
        lat0, lon0, h0 = site
        topocentric = Transformer.from_pipeline(
            f"+proj=topocentric +ellps=WGS84 +lat_0={lat0!r} +lon_0={lon0!r} +h_0={h0!r}")
        targets = [site]
        while len(targets) < 24:
            reach = rng.choice([10, 500, 5_000, 20_000, 100_000]) * math.sqrt(rng.random())
            bearing, height = rng.uniform(0, 2 * math.pi), rng.choice([rng.uniform(-100, 500), rng.uniform(-100, 10_000)])
            geod = pyproj.Geod(ellps="WGS84")
            lon, lat, _ = geod.fwd(lon0, lat0, math.degrees(bearing), reach)
            targets.append((round(lat, 9), round(lon, 9), round(height, 3)))
        for lat, lon, h in targets:
            ecef = cart.transform(lon, lat, h)
            exact = to_ecef(lat, lon, h)
            assert max(abs(a - b) for a, b in zip(ecef, exact)) < 1e-8, (lat, lon, h)
            writer.writerow(repr(float(v)) for v in (lat0, lon0, h0, lat, lon, h, *ecef, *topocentric.transform(*ecef)))


# --- radar -----------------------------------------------------------------------------------------------------------

def by_formula(latitude, radar_height, slant_range, azimuth, height):
    """East, north, up by the sphere of the Gaussian mean radius, and whether the sine was clamped; angles in degrees."""
    radius = A * mpmath.sqrt(1 - E2) / (1 - E2 * mpmath.sin(mpmath.radians(mpf(latitude))) ** 2)
    rho, theta = mpf(slant_range), mpmath.radians(mpf(azimuth))
    up_to_radar, up_to_target = radius + mpf(radar_height), radius + mpf(height)
    sine = (up_to_target ** 2 - up_to_radar ** 2 - rho ** 2) / (2 * rho * up_to_radar)
    clamped = abs(sine) > 1
    sine = max(mpf(-1), min(mpf(1), sine))
    ground = rho * mpmath.sqrt(1 - sine ** 2)
    return (ground * mpmath.sin(theta), ground * mpmath.cos(theta), rho * sine), clamped


def on_ellipsoid(latitude, longitude, radar_height, slant_range, azimuth, height):
    """East, north, up of the point at that range and azimuth whose height above the ellipsoid is `height`, by search."""
    rho, theta = mpf(slant_range), mpmath.radians(mpf(azimuth))

    def at(elevation):
        ground = rho * mpmath.cos(elevation)
        return ground * mpmath.sin(theta), ground * mpmath.cos(theta), rho * mpmath.sin(elevation)

    def miss(elevation):
        return height_of(enu_to_ecef((latitude, longitude, radar_height), at(elevation))) - mpf(height)

    start = mpmath.asin((mpf(height) - mpf(radar_height)) / rho)
    return at(mpmath.findroot(miss, (start, start - mpf("0.001")), tol=1e-20))


def polar(rng, writer):
    writer.writerow("lat0 lon0 h0 rho theta h e n u e_ellipsoid n_ellipsoid u_ellipsoid difference".split())
    for site in SITES + SITES:
        lat0, lon0, h0 = site
        for reach in (rng.uniform(50, 1000), rng.uniform(1000, 5000), 5000.0, rng.uniform(5000, 20_000), 20_000.0,
                      rng.uniform(20_000, 100_000)):
            rho = max(1, round(reach * 256 / 1852)) * 1852 / 256       # as I048/040 can state it
            theta = rng.randrange(65536) * 360 / 65536
            h = round(h0 + rng.uniform(-0.1, min(0.9, 3000 / rho)) * rho, 3)
            point, clamped = by_formula(lat0, h0, rho, theta, h)
            assert not clamped
            exact = on_ellipsoid(lat0, lon0, h0, rho, theta, h)
            difference = mpmath.sqrt(sum((a - b) ** 2 for a, b in zip(point, exact)))
            writer.writerow(repr(float(v)) for v in (lat0, lon0, h0, rho, theta, h, *point, *exact, difference))
    for rho, theta, h in (100.0, 45.0, 500.0), (100.0, 200.0, -400.0), (7.234375, 0.0, 105.0 + 7.3), (50.0, 90.0, 55.0):
        # no point of the ellipsoid has this range and height: the sine is clamped, or just about to be
        point, _ = by_formula(52.5065, 105.0, rho, theta, h)
        writer.writerow([repr(float(v)) for v in (52.5065, -0.588, 105.0, rho, theta, h, *point)] + [""] * 4)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path)
    folder = parser.parse_args().folder
    versions = f"SciPy {scipy.__version__}, NumPy {np.__version__}, PROJ {pyproj.proj_version_str}, mpmath {mpmath.__version__}"
    for make, what in (
            (pchip, "PCHIP: knots (times in s, values in m) and the curve (result) at abscissae (at)"),
            (geodesy, "WGS-84: origin and target geodetic (degrees, m), target ECEF (m) and ENU about the origin (m)"),
            (polar, "plots: radar (degrees, m), slant range (m), azimuth (degrees), height (m) to ENU about the radar (m)")):
        with open(folder / f"{make.__name__}.csv", "w", newline="") as file:
            file.write(f"# make_tables.py, {versions}. {what}\n")
            make(random.Random(SEED), csv.writer(file, lineterminator="\n"))


if __name__ == "__main__":
    main()
