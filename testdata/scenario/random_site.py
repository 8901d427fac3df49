#!/usr/bin/env python3
"""A random site: what the demonstration flight and the conformance cases leave out.

    python3 random_site.py SEED FOLDER

Three radars (each classification; one bears a correction, one a period of 1.3 s, one sees no heights), two receivers, odd
identities, both lengths of I129/120, several records in a block, plots that must not count, reports late, ahead, twice,
out of order, midnight, a silence. Writes capture.pcap and site.toml; `oracle/reference.py` says what must come out.
Standard library only; the same seed gives the same bytes.
"""

import math
import os
import random
import struct
import sys

import generate as base
from generate import block, geodetic, record, time_of_day

RADARS = [  # id, SIC, east and north of the first (m), correction (degrees), period (s), classification, heights
    ("alpha", 11, 0.0, 0.0, 0.8, 0.25, '{ source = "special-purpose", octet = 1 }', 0.9),
    ("bravo", 12, 900.0, -700.0, -1.5, 1.3, '{ source = "target-classification" }', 0.5),
    ("charlie", 13, -1500.0, 400.0, 0.0, 0.5, '{ source = "constant", value = 0.25 }', 0.0),
]
SERIALS = [(b"  ODD ONE \0\0", b"NO"), (b"000000000042", b"SE"), (b"000000000042", b"FI"), (b"\0CONFIGURED ", None),
           (b"0000000429497"[1:], b"  "), (b"12\xff\x01        ", b"DK")]
DURATION = 90.0


def position(target, t):
    """East, north, height AMSL of a target: a circle that drifts."""
    e0, n0, radius, speed, ve, vn, height = target
    angle = speed * t / radius
    return e0 + ve * t + radius * math.cos(angle), n0 + vn * t + radius * math.sin(angle), height + 8 * math.sin(t / 9)


def plot(rng, t, radar, target, track):
    name, sic, east, north, correction, _, _, heights = radar
    e, n, height = position(target, t)
    theta = math.degrees(math.atan2(e - east, n - north)) - correction + rng.gauss(0, 0.4)
    rho = math.hypot(e - east, n - north, height - base.HEIGHT_AMSL) + rng.gauss(0, 5)
    items = {1: bytes([70, sic]), 2: time_of_day(t), 3: b"\x20",
             4: struct.pack(">HH", max(0, round(rho * 256 / 1852)), round(theta * 65536 / 360) % 65536),
             11: struct.pack(">H", track | rng.choice([0, 0xF000]))}
    if rng.random() < heights:
        items[19] = struct.pack(">H", round((height + rng.gauss(0, 8)) / 7.62) & 0x3FFF)
    if rng.random() < 0.9:
        items[27] = bytes([4, 9, rng.choice([0, 0, 1, 128, 255]), 7]) if rng.random() < 0.9 else bytes([2, 200])
    if rng.random() < 0.4:
        items[16] = rng.choice([b"\x26", b"\x10", b"\x13\x26", b"\x02"])   # birds, drone, drone and birds, multipath
    luck = rng.random()
    if luck < 0.01:
        items[3] = rng.choice([b"\x00", b"\x30", b"\x21\x80", b"\x21\x00"])  # coasted, simulated, test, none of these
    elif luck < 0.02:
        del items[rng.choice([1, 2, 3, 4, 11])]
    elif luck < 0.025:
        items[4] = b"\0\0" + items[4][2:]
    elif luck < 0.03:
        items[2] = rng.choice([b"\xa8\xc0\x00", b"\xa8\xc0\x01"])          # the next midnight, and beyond
    return record(items)


def report(rng, t, target, serial, country, sic):
    e, n, height = position(target, t)
    latitude, longitude, _ = geodetic(e + rng.gauss(0, 1.5), n + rng.gauss(0, 1.5), height - base.HEIGHT_AMSL)
    items = {1: bytes([0, sic]), 5: serial, 7: time_of_day(t),
             8: base.signed(latitude * 2**30 / 180, 4) + base.signed(longitude * 2**30 / 180, 4),
             9: base.signed(height * 10, 3)}
    if country:
        items[6] = country
    if rng.random() < 0.5:
        items[3] = rng.choice([b"AAA", b"BBB"])
    if rng.random() < 0.3:
        items[12] = rng.choice([b"\x40", b"\x40\x01\x02"])
    luck = rng.random()
    if luck < 0.02:
        del items[rng.choice([5, 7, 8, 9])]
    elif luck < 0.03:
        items[8] = b"\x7f\0\0\0" + items[8][4:]
    elif luck < 0.04:
        items[5] = b" \0 \0" * 3
    return record(items)


def flight(rng):
    targets = [(rng.uniform(-900, 900), rng.uniform(300, 1500), rng.uniform(60, 250), rng.uniform(5, 15),
                rng.uniform(-4, 4), rng.uniform(-4, 4), rng.uniform(90, 160)) for _ in range(8)]
    shadows = [rng.choice([(0, 0), (0, 0), (0, 40), (30, 60), (0, DURATION)]) for _ in targets]    # no radar sees it then
    silence = rng.choice([0, 0, 60])
    datagrams = []

    def send(t, octets, delay):
        datagrams.append((round((base.START + later(t) + delay) * 1e6), base.RADAR_NET, octets))

    def later(t):
        """The second half flies after the silence."""
        return t + silence if t > 45 else t

    for radar in RADARS:
        tracks = {index: rng.randint(0, 15) for index in range(8)}
        for scan in range(int(DURATION / radar[5])):
            t = scan * radar[5]
            plots = []
            for index, target in enumerate(targets):
                if rng.random() < 0.01:
                    tracks[index] = rng.randint(0, 4095)
                if rng.random() < 0.92 and not shadows[index][0] <= t < shadows[index][1]:
                    plots.append(plot(rng, later(t + rng.uniform(0, radar[5])), radar, target, tracks[index]))
            if plots:
                delay = radar[5] + (rng.uniform(0, 9) if rng.random() < 0.03 else rng.uniform(0.02, 0.4))
                send(t, b"".join(block(48, *plots[i:i + 3]) for i in range(0, len(plots), 3)), delay)
    for (serial, country), target in zip(SERIALS, targets):
        t = rng.uniform(0, 2)
        while t < DURATION:
            if rng.random() < 0.9:
                luck = rng.random()
                delay = rng.uniform(-1.2, 0) if luck < 0.05 else rng.uniform(0, 30) if luck < 0.1 else rng.uniform(0.1, 1.5)
                send(t, block(129, report(rng, later(t), target, serial, country, rng.choice([0, 1]))), delay)
            t += rng.choice([0.5, 2.0, 2.0, 4.0]) + rng.uniform(-0.05, 0.05)
    for reception, network, octets in rng.sample(datagrams, 20):
        datagrams.append((reception + rng.choice([1, 500_000, 1_999_999, 2_000_001]), network, octets))
    return datagrams


def site():
    text = base.SITE[:base.SITE.index("[[sensors]]")]
    for name, sic, east, north, correction, period, classification, _ in RADARS:
        latitude, longitude, _ = geodetic(east, north, 0.0)
        text += (f'[[sensors]]\nkind = "radar"\nid = "{name}"\nsac = 70\nsic = {sic}\nlatitude_deg = {latitude!r}\n'
                 f"longitude_deg = {longitude!r}\nheight_amsl_m = {base.HEIGHT_AMSL}\nbearing_correction_deg = {correction}\n"
                 f"period_s = {period}\nassumed_height_amsl_m = 120.0\nclassification = {classification}\n\n")
    for sic in (0, 1):
        text += f'[[sensors]]\nkind = "transponder"\nid = "receiver-{sic}"\nsac = 0\nsic = {sic}\nperiod_s = 2.0\n\n'
    return text + '[fusion]\nprofile = "reference"\ntransponder_numbers = { "CONFIGURED" = 2 }\n'


def main():
    seed, folder = int(sys.argv[1]), sys.argv[2]
    os.makedirs(folder, exist_ok=True)
    base.write_capture(os.path.join(folder, "capture.pcap"), flight(random.Random(seed)))
    with open(os.path.join(folder, "site.toml"), "w") as file:
        file.write(site())


if __name__ == "__main__":
    main()
