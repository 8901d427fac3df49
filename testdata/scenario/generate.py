#!/usr/bin/env python3
"""The bundled demonstration flight: three drones and three birds about a drone radar, through midnight.

    python3 generate.py FOLDER

Writes capture.pcap, site.toml, truth.csv and labels.csv into FOLDER. Standard library only and seeded: always the same
bytes. Units: metres, seconds (t counts from the start of the flight), degrees clockwise from true north.
"""

import argparse
import csv
import ipaddress
import math
import pathlib
import random
import struct
from dataclasses import dataclass
from datetime import datetime, timezone

SEED = 48
START = int(datetime(2026, 6, 20, 23, 59, 30, tzinfo=timezone.utc).timestamp())
DURATION = 75.0
TRUTH_STEP = 0.1

# the site: fictitious, on flat ground 64 m above mean sea level
LATITUDE, LONGITUDE, HEIGHT_AMSL, UNDULATION = 53.0817, 10.3264, 72.0, 43.2
GROUND_AMSL = 64.0
SERVICE, RADAR, TRANSPONDER = (70, 1), (70, 41), (0, 0)
BEARING_ERROR = -0.8            # the radar reads low by this much; site.toml corrects it
SCAN = 0.25
DETECTION = 0.9
SIGMA_RANGE, SIGMA_AZIMUTH, SIGMA_HEIGHT = 4.0, 0.3, 7.0

RADAR_NET = "10.20.30.48", "239.192.70.48", 8048
TRANSPONDER_NET = "10.20.30.129", "239.192.70.129", 8129


# --- motion ----------------------------------------------------------------------------------------------------------

def fly(east, north, height, heading, speed, legs):
    """[(e, n, height above ground, ve, vn, vu)] every TRUTH_STEP; a leg is (seconds, turn rate in degrees/s, climb in m/s)."""
    states = []
    rates = [leg[1:] for leg in legs for _ in range(round(leg[0] / TRUTH_STEP))]
    steps = round(DURATION / TRUTH_STEP) + 1
    for turn, climb in (rates + [(0.0, 0.0)] * steps)[:steps]:
        heading += turn * TRUTH_STEP
        ve, vn = speed * math.sin(math.radians(heading)), speed * math.cos(math.radians(heading))
        states.append((east, north, height, ve, vn, climb))
        east, north, height = east + ve * TRUTH_STEP, north + vn * TRUTH_STEP, height + climb * TRUTH_STEP
    return states


def survey(speed, leg_s, turn_s):
    """Legs there and back, joined by half circles to alternate sides."""
    legs = []
    for side in (1, -1, 1, -1, 1):
        legs += [(leg_s, 0.0, 0.0), (turn_s, side * 180 / turn_s, 0.0)]
    return fly(-30.0, 950.0, 80.0, 70.0, speed, legs)


def wander(rng, east, north, height, heading, speed):
    """A bird: a new turn and a new climb every second or two."""
    legs = [(rng.choice([1.0, 1.5, 2.0]), rng.gauss(0, 18), rng.gauss(0, 0.8)) for _ in range(80)]
    return fly(east, north, height, heading, speed, legs)


def at(states, t):
    """The state at time t, by a straight line between two steps."""
    index = min(int(t / TRUTH_STEP), len(states) - 2)
    part = t / TRUTH_STEP - index
    return [a + (b - a) * part for a, b in zip(states[index], states[index + 1])]


@dataclass
class Target:
    """`tracks`: (from, to, track number, with height); `likely`: how often the radar's UAV probability is above 0."""
    id: str                     # empty: a bird
    states: list
    tracks: list
    likely: float
    serial: str = ""            # empty: no transponder
    model: str = ""
    number: int = 0             # the number the service gives the transponder
    offset: float = 0.0         # of the transponder's clockwork
    silent: tuple = (0.0, 0.0)


def targets(rng):
    return [
        Target("ALPHA", survey(12.0, 12.0, 5.5),
               [(0.0, 41.0, 11, True), (54.0, 61.0, 27, False), (62.5, 75.0, 31, True)],
               0.95, "DRONE-ALPHA ", "SRV", 7, 0.35),
        Target("BRAVO", fly(-480.0, 820.0, 60.0, 82.0, 14.0,
                            [(12, 0, 0.5), (8, 5, 1.0), (20, -2, 0.5), (10, 6, -0.5), (25, -3, -1.0)]),
               [(11.0, 75.0, 12, True)],
               0.9, "000000004711", "CRG", 4711, 1.2, (36.0, 51.5)),
        Target("CHARLIE", fly(620.0, -310.0, 45.0, 10.0, 16.0,
                              [(10, 0, 0.3), (20, 7.5, 0.6), (15, -7.5, 0.0), (30, 6, -0.4)]),
               [(3.0, 40.0, 14, True), (40.0, 67.0, 29, True), (67.0, 75.0, 29, False)], 0.92),
        Target("", wander(rng, 250.0, 500.0, 40.0, 300.0, 10.0),
               [(0.0, 11.0, 15, True), (14.0, 24.0, 18, True), (27.0, 38.5, 22, True), (46.0, 55.0, 26, True),
                (60.0, 72.0, 33, True)], 0.12),
        Target("", wander(rng, -420.0, -260.0, 70.0, 40.0, 12.0),
               [(5.0, 12.0, 16, True), (16.0, 29.0, 19, True), (33.0, 43.0, 24, True), (55.0, 69.0, 32, True)], 0.03),
        Target("", wander(rng, 380.0, 1150.0, 95.0, 200.0, 13.0),
               [(9.0, 15.0, 17, False), (21.0, 30.0, 21, True), (36.0, 47.0, 25, True), (51.0, 58.0, 28, True)], 0.0),
    ]


# --- geodesy ---------------------------------------------------------------------------------------------------------

A, F = 6378137.0, 1 / 298.257223563
E2 = F * (2 - F)


def normal_radius(phi):
    return A / math.sqrt(1 - E2 * math.sin(phi) ** 2)


def geodetic(e, n, u):
    """Latitude, longitude (degrees) and ellipsoidal height of a point about the radar."""
    phi, lam, height = math.radians(LATITUDE), math.radians(LONGITUDE), HEIGHT_AMSL + UNDULATION
    ground = (normal_radius(phi) + height) * math.cos(phi) - n * math.sin(phi) + u * math.cos(phi)
    x, y = ground * math.cos(lam) - e * math.sin(lam), ground * math.sin(lam) + e * math.cos(lam)
    z = (normal_radius(phi) * (1 - E2) + height) * math.sin(phi) + n * math.cos(phi) + u * math.sin(phi)
    ground = math.hypot(x, y)
    for _ in range(10):
        phi = math.atan2(z + E2 * normal_radius(phi) * math.sin(phi), ground)
    height = ground * math.cos(phi) + z * math.sin(phi) - A * A / normal_radius(phi)
    return math.degrees(phi), math.degrees(math.atan2(y, x)), height


def up_of(e, n, height_amsl):
    """The ENU height of a point that is `height_amsl` above mean sea level."""
    up = height_amsl - HEIGHT_AMSL
    for _ in range(4):
        up -= geodetic(e, n, up)[2] - UNDULATION - height_amsl
    return up


def place(states, t):
    """(e, n, u, height AMSL) at time t."""
    e, n, above_ground, *_ = at(states, t)
    return e, n, up_of(e, n, above_ground + GROUND_AMSL), above_ground + GROUND_AMSL


# --- ASTERIX ---------------------------------------------------------------------------------------------------------

def record(items):
    """A record from {FRN: octets}, with the shortest FSPEC."""
    octets = bytearray((max(items) + 6) // 7)
    for frn in items:
        octets[(frn - 1) // 7] |= 0x80 >> (frn - 1) % 7
    for index in range(len(octets) - 1):
        octets[index] |= 1
    return bytes(octets) + b"".join(items[frn] for frn in sorted(items))


def block(category, *records):
    body = b"".join(records)
    return struct.pack(">BH", category, 3 + len(body)) + body


def ticks(t):
    """A time of the flight in counts of 1/128 s since the epoch."""
    return math.floor((START + t) * 128)


def time_of_day(t):
    return (ticks(t) % (86_400 * 128)).to_bytes(3, "big")


def signed(value, length):
    return round(value).to_bytes(length, "big", signed=True)


def plot_record(t, rho, theta, height_amsl, track, probability, source=RADAR):
    """A CAT048 primary plot; height_amsl None: not measured. The UAV probability is octet 0 of the special purpose field."""
    items = {
        1: bytes(source), 2: time_of_day(t), 3: b"\x20",
        4: struct.pack(">HH", round(rho * 256 / 1852), round(theta * 65536 / 360) % 65536),
        11: struct.pack(">H", track), 27: bytes([2, probability])}
    if height_amsl is not None:
        items[19] = struct.pack(">H", round(height_amsl / 7.62) & 0x3FFF)
    return record(items)


def report_record(t, target, latitude, longitude, height_amsl, velocity, source=TRANSPONDER):
    """A CAT129 report with accuracy and velocity."""
    east, north, up = (round(100 * v) for v in velocity)
    return record({
        1: bytes(source), 3: b"UTM", 4: target.model.encode(), 5: target.serial.encode(), 6: b"DE", 7: time_of_day(t),
        8: signed(latitude * 2**30 / 180, 4) + signed(longitude * 2**30 / 180, 4), 9: signed(height_amsl * 10, 3),
        11: struct.pack(">H", 2), 14: ((east & 0xFFFFF) << 20 | north & 0xFFFFF).to_bytes(5, "big"),
        15: (up & 0xFFFFF).to_bytes(3, "big")})


def service_message(t, sector):
    """CAT034: north marker for sector 0, sector crossing otherwise."""
    kind = b"\x01" if sector == 0 else b"\x02"
    return record({1: bytes(RADAR), 2: kind, 3: time_of_day(t), 4: bytes([sector]), 5: struct.pack(">H", round(SCAN * 128))})


# --- sensors ---------------------------------------------------------------------------------------------------------

class Scene:
    """Collects datagrams (reception time, network, octets) and labels (ticks, sensor, number, id)."""

    def __init__(self):
        self.rng = random.Random(SEED)
        self.targets = targets(self.rng)
        self.datagrams, self.labels = [], []

    def send(self, t, network, octets):
        self.datagrams.append((round((START + t) * 1e6), network, octets))

    def detect(self, scan, target):
        """The plot of a target in the scan that began at `scan`, or nothing; the beam turns once a scan."""
        rng = self.rng
        track = next((track for track in target.tracks if track[0] <= scan < track[1]), None)
        missed = rng.random() >= DETECTION
        if track is None or missed:
            return None
        e, n, *_ = place(target.states, scan)
        t = min(scan + SCAN * (math.degrees(math.atan2(e, n)) % 360) / 360, DURATION)
        e, n, u, height_amsl = place(target.states, t)
        rho = math.hypot(e, n, u) + rng.gauss(0, SIGMA_RANGE)
        theta = (math.degrees(math.atan2(e, n)) + BEARING_ERROR + rng.gauss(0, SIGMA_AZIMUTH)) % 360
        height_amsl += rng.gauss(0, SIGMA_HEIGHT)
        probability = rng.randint(90, 250) if target.id else rng.randint(10, 60)
        if rng.random() >= target.likely:
            probability = 0
        self.labels.append((ticks(t), "halfmoon", track[2], target.id))
        return plot_record(t, rho, theta, height_amsl if track[3] else None, track[2], probability)

    def radar(self):
        for index in range(int(DURATION / SCAN)):
            scan = index * SCAN
            plots = [plot for plot in (self.detect(scan, target) for target in self.targets) if plot]
            octets = block(48, *plots) if plots else b""
            if index % 8 == 0:
                octets = block(34, service_message(scan, 0)) + octets
            elif index % 8 == 4:
                octets = block(34, service_message(scan + SCAN / 2, 128)) + octets
            if octets:
                self.send(scan + SCAN + self.rng.uniform(0.02, 0.12), RADAR_NET, octets)

    def transponder(self, target):
        rng, t = self.rng, target.offset
        while t < DURATION:
            moment = t + rng.uniform(-0.1, 0.1)
            if not target.silent[0] <= t < target.silent[1]:
                e, n, u, _ = place(target.states, moment)
                latitude, longitude, height = geodetic(e + rng.gauss(0, 1.2), n + rng.gauss(0, 1.2), u + rng.gauss(0, 1.5))
                velocity = at(target.states, moment)[3:]
                report = report_record(moment, target, latitude, longitude, height - UNDULATION, velocity)
                self.labels.append((ticks(moment), "squitter", target.number, target.id))
                self.send(moment + rng.uniform(0.05, 0.6), TRANSPONDER_NET, block(129, report))
            t += 2.0

    def disturb(self):
        """Bad input, as a network brings it."""
        drone = self.targets[0]
        e, n, u, height = place(drone.states, 2.0)
        latitude, longitude, _ = geodetic(e, n, u)
        def report(t, **source):
            return block(129, report_record(t, drone, latitude, longitude, height, (0, 0, 0), **source))
        def plot(t, **source):
            return block(48, plot_record(t, 900.0, 120.0, 110.0, 99, 200, **source))

        self.send(12.01, RADAR_NET, block(250, b"\x80\x46\x29"))              # unknown category
        self.send(20.02, RADAR_NET, plot(19.9)[:-6])                         # truncated
        self.send(28.03, RADAR_NET, b"\x30\x00\x02")                         # LEN below 3
        self.send(33.04, RADAR_NET, plot(32.9, source=(99, 9)))              # a radar nobody configured
        self.send(34.05, TRANSPONDER_NET, report(33.9, source=(99, 10)))     # a receiver nobody configured
        self.send(44.06, TRANSPONDER_NET, report(2.0))                       # 42 s late
        self.send(55.07, TRANSPONDER_NET, report(58.5))                      # from the future
        first_copies = [datagram for datagram in self.datagrams if START + 24 < datagram[0] / 1e6 < START + 25]
        for reception, network, octets in first_copies:                      # a redundant line
            self.datagrams.append((reception + 4_000, network, octets))


# --- files -----------------------------------------------------------------------------------------------------------

def checksum(octets):
    total = sum(struct.unpack(f">{len(octets) // 2}H", octets))
    while total >> 16:
        total = (total & 0xFFFF) + (total >> 16)
    return ~total & 0xFFFF


def frame(network, identification, payload):
    """An Ethernet frame with IPv4 and UDP to a multicast group."""
    source, group, port = network
    addresses = ipaddress.ip_address(source).packed + ipaddress.ip_address(group).packed
    udp = struct.pack(">4H", port, port, 8 + len(payload), 0) + payload
    pseudo = addresses + struct.pack(">HH", 17, len(udp)) + udp + b"\0" * (len(udp) % 2)
    udp = udp[:6] + struct.pack(">H", checksum(pseudo) or 0xFFFF) + udp[8:]
    header = struct.pack(">BBHHHBBH", 0x45, 0, 20 + len(udp), identification, 0x4000, 16, 17, 0) + addresses
    header = header[:10] + struct.pack(">H", checksum(header)) + header[12:]
    ethernet = b"\x01\x00\x5e" + bytes([addresses[5] & 0x7F]) + addresses[6:] + b"\x02\x00" + addresses[:4] + b"\x08\x00"
    return ethernet + header + udp


def write_capture(path, datagrams):
    with open(path, "wb") as file:
        file.write(struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 1))
        for identification, (reception, network, payload) in enumerate(sorted(datagrams)):
            octets = frame(network, identification, payload)
            file.write(struct.pack("<4I", *divmod(reception, 1_000_000), len(octets), len(octets)) + octets)


def write_truth(path, targets):
    with open(path, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow("time id lat lon alt_msl vn ve vd".split())
        for index in range(round(DURATION / TRUTH_STEP) + 1):
            for target in targets:
                if target.id:
                    e, n, above_ground, ve, vn, vu = target.states[index]
                    height_amsl = above_ground + GROUND_AMSL
                    latitude, longitude, _ = geodetic(e, n, up_of(e, n, height_amsl))
                    writer.writerow([f"{START + index * TRUTH_STEP:.3f}", target.id, f"{latitude:.9f}", f"{longitude:.9f}",
                                     f"{height_amsl:.3f}", f"{vn:.3f}", f"{ve:.3f}", f"{-vu:.3f}"])


def write_labels(path, labels):
    with open(path, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow("time sensor number id seduced".split())
        for moment, sensor, number, id in sorted(labels):
            writer.writerow([f"{moment / 128:.7f}", sensor, number, id, 0])


SITE = f"""\
# The demonstration site; fictitious, as is everything that flies there.
[site]
name = "lueneheide"
sac = {SERVICE[0]}
sic = {SERVICE[1]}
geoid_undulation_m = {UNDULATION}

[[sensors]]
kind = "radar"
id = "halfmoon"
sac = {RADAR[0]}
sic = {RADAR[1]}
latitude_deg = {LATITUDE}
longitude_deg = {LONGITUDE}
height_amsl_m = {HEIGHT_AMSL}
bearing_correction_deg = {-BEARING_ERROR}
period_s = {SCAN}
max_range_m = 5000.0
assumed_height_amsl_m = 130.0
classification = {{ source = "special-purpose", octet = 0 }}
accuracy = {{ range_m = 4.0, azimuth_deg = 0.3, height_m = 7.0 }}
inputs = [{{ group = "{RADAR_NET[1]}", port = {RADAR_NET[2]}, interface = "127.0.0.1" }}]

[[sensors]]
kind = "transponder"
id = "squitter"
sac = {TRANSPONDER[0]}
sic = {TRANSPONDER[1]}
period_s = 2.0
accuracy = {{ horizontal_m = 2.0, vertical_m = 3.0 }}
inputs = [{{ group = "{TRANSPONDER_NET[1]}", port = {TRANSPONDER_NET[2]}, interface = "127.0.0.1" }}]

[fusion]
profile = "reference"
latency_s = 6.25
window_s = 25.0
transponder_numbers = {{ "DRONE-ALPHA" = 7 }}

[output]
asterix = [{{ group = "239.192.70.130", port = 8130, interface = "127.0.0.1", ttl = 1 }}]
status = false

[http]
listen = "127.0.0.1:8080"
auth = {{ mode = "none" }}
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path)
    folder = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    scene = Scene()
    scene.radar()
    for target in scene.targets:
        if target.serial:
            scene.transponder(target)
    scene.disturb()
    write_capture(folder / "capture.pcap", scene.datagrams)
    write_truth(folder / "truth.csv", scene.targets)
    write_labels(folder / "labels.csv", scene.labels)
    (folder / "site.toml").write_text(SITE)


if __name__ == "__main__":
    main()
