#!/usr/bin/env python3
"""Computes the figures of `utm-fusion assess` a second time, from docs/ASSESS.md and docs/METRICS.md alone.

  check.py REPORT.json CAPTURE.pcap SITE.toml DECODED.ndjson PICTURE.ndjson [TRUTH.csv]

DECODED is of `decode`, PICTURE of `replay -o`. Prints each figure that differs in a printed digit, and the number compared. Exit
code 1 if a figure differs or is missing. Figures of the engine's registration are not recomputed.
"""

import bisect
import csv
import json
import math
import struct
import sys
import tomllib
from collections import Counter, defaultdict
from datetime import datetime, timezone
from decimal import Decimal

NS = 10**9
A, F = 6378137.0, 1 / 298.257223563
E2 = F * (2 - F)
SEED = 1


# Time and place


def stamp(text):
    """RFC 3339 or decimal seconds, as nanoseconds."""
    if "T" in text:
        whole, _, fraction = text.rstrip("Z").partition(".")
        moment = datetime.strptime(whole, "%Y-%m-%dT%H:%M:%S").replace(tzinfo=timezone.utc)
        return int(moment.timestamp()) * NS + int((fraction + "0" * 9)[:9])
    return int(Decimal(text) * NS)


def to_ecef(lat, lon, height):
    n = A / math.sqrt(1 - E2 * math.sin(lat) ** 2)
    flat = (n + height) * math.cos(lat)
    return (flat * math.cos(lon), flat * math.sin(lon), (n * (1 - E2) + height) * math.sin(lat))


def to_geodetic(x, y, z):
    flat, lon, lat = math.hypot(x, y), math.atan2(y, x), math.atan2(z, math.hypot(x, y) * (1 - E2))
    for _ in range(20):
        n = A / math.sqrt(1 - E2 * math.sin(lat) ** 2)
        lat = math.atan2(z + E2 * n * math.sin(lat), flat)
    n = A / math.sqrt(1 - E2 * math.sin(lat) ** 2)
    return lat, lon, flat * math.cos(lat) + z * math.sin(lat) - A * A / n


def offset(place, origin):
    """Metres east, north and up (None without heights) of a place (degrees, metres) from another."""
    sin = math.sin(math.radians(origin[0]))
    normal = A / math.sqrt(1 - E2 * sin**2)
    meridian = normal * (1 - E2) / (1 - E2 * sin**2)
    height = origin[2] or 0.0
    east = (place[1] - origin[1] + 180) % 360 - 180
    middle = math.radians(0.5 * (place[0] + origin[0]))
    up = None if place[2] is None or origin[2] is None else place[2] - origin[2]
    return math.radians(east) * (normal + height) * math.cos(middle), math.radians(place[0] - origin[0]) * (meridian + height), up


def length(of):
    return math.hypot(of[0], of[1])


def length_3d(of):
    return math.hypot(length(of), of[2] or 0.0)


# Reference


class Path:
    """True path of an aircraft."""

    def __init__(self, samples):
        samples = sorted({time: place for time, place in samples}.items())
        self.times, self.places = [time for time, _ in samples], [place for _, place in samples]

    def at(self, time, across_holes=False):
        after = bisect.bisect_left(self.times, time)
        if after == len(self.times):
            return None
        if self.times[after] == time:
            return self.places[after]
        if after == 0:
            return None
        start, end = self.times[after - 1], self.times[after]
        if end - start > 5 * NS and not across_holes:
            return None
        (lat, lon, height), (lat_2, lon_2, height_2) = self.places[after - 1], self.places[after]
        share = ((time - start) / NS) / ((end - start) / NS)
        east = (lon_2 - lon + 180) % 360 - 180
        up = None if height is None or height_2 is None else height + share * (height_2 - height)
        return lat + share * (lat_2 - lat), (lon + share * east + 180) % 360 - 180, up

    def holes(self):
        return [(a, b) for a, b in zip(self.times, self.times[1:]) if b - a > 5 * NS]

    def motion(self, time):
        before, now, after = self.at(time - NS), self.at(time), self.at(time + NS)
        half = self.at(time - NS // 2), self.at(time + NS // 2)
        if None in (before, now, after, *half):
            return None
        if length(offset(half[1], half[0])) < 2:
            return "hovering"
        to, away = offset(now, before), offset(after, now)
        if length(to) > 2 and length(away) > 2:
            turn = math.atan2(to[0] * away[1] - to[1] * away[0], to[0] * away[0] + to[1] * away[1])
            if abs(math.degrees(turn)) > 4:
                return "turning"
        return "straight"

    def velocity(self, time):
        half = self.at(time - NS // 2), self.at(time + NS // 2)
        return None if None in half else offset(half[1], half[0])[:2]


class Reference:
    def __init__(self, paths, slot_ns, is_truth, classes):
        self.ids = sorted(paths, key=lambda name: name.encode())
        self.paths = [paths[name] for name in self.ids]
        self.slot_ns, self.is_truth, self.classes = slot_ns, is_truth, classes
        self.pieces = [self.counted(path) for path in self.paths]
        slots = [slot for pieces in self.pieces for piece in pieces for slot in piece]
        self.run = (min(slots), max(slots)) if slots else None
        self.aircraft = sum(1 for pieces in self.pieces if pieces)
        self.counting = [{s for first, last in pieces for s in range(first, last + 1)} for pieces in self.pieces]
        self.equipped = set()

    def centre(self, slot):
        return slot * self.slot_ns + self.slot_ns // 2

    def counted(self, path):
        start, end = path.times[0] + 10 * NS, path.times[-1] - 15 * NS // 2
        pieces, edges = [], []
        for hole, after in path.holes():
            edges.append((start, min(hole, end)))
            start = max(start, after)
        edges.append((start, end))
        for first_ns, last_ns in edges:
            first, last = first_ns // self.slot_ns, last_ns // self.slot_ns
            first += self.centre(first) < first_ns
            last -= self.centre(last) > last_ns
            if first <= last:
                pieces.append((first, last))
        return pieces

    def piece(self, time):
        return (time - self.run[0] * self.slot_ns) // (60 * NS)

    def block(self, drone, time):
        return (drone, self.piece(time) if self.aircraft < 8 else 0)

    def score(self, points):
        """Points that count: (point, slot, drone or None, true place, error)."""
        scored = []
        for point in points:
            slot = point["time"] // self.slot_ns
            if not self.run or not self.run[0] <= slot <= self.run[1]:
                continue
            best, in_hole = None, False
            for drone, path in enumerate(self.paths):
                if not path.times[0] <= point["time"] <= path.times[-1]:
                    continue
                place = path.at(point["time"])
                is_known = place is not None
                place = place or path.at(point["time"], across_holes=True)
                # Nothing is nearer than its difference of latitude.
                if abs(place[0] - point["place"][0]) > 0.0015:
                    continue
                distance = length_3d(offset(point["place"], place))
                if distance <= 150:
                    in_hole |= not is_known
                    if is_known and (best is None or (distance, drone) < best):
                        best = (distance, drone)
            if best is None:
                if not in_hole:
                    scored.append((point, slot, None, None, None))
            elif slot in self.counting[best[1]]:
                truth = self.paths[best[1]].at(point["time"])
                scored.append((point, slot, best[1], truth, offset(point["place"], truth)))
        return scored

    def flown(self, unit_s, subject=None):
        sums = defaultdict(lambda: [0.0, 0.0])
        for drone, pieces in enumerate(self.pieces):
            if subject and not self.covers(subject, drone):
                continue
            for first, last in pieces:
                for slot in range(first, last + 1):
                    sums[self.block(drone, self.centre(slot))][1] += self.slot_ns / NS / unit_s
        return sums

    def covers(self, subject, drone):
        return subject.kind != "receiver" or drone in self.equipped

    def run_time(self, unit_s):
        sums = defaultdict(lambda: [0.0, 0.0])
        for slot in range(self.run[0], self.run[1] + 1) if self.run else ():
            sums[(-1, self.piece(self.centre(slot)))][1] += self.slot_ns / NS / unit_s
        return sums


# Intervals


def quantile(values, share):
    if not values:
        return None
    place = share * (len(values) - 1)
    low, high = math.floor(place), math.ceil(place)
    return values[low] + (place - low) * (values[high] - values[low])


def solve(low, high, is_below):
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (middle, high) if is_below(middle) else (low, middle)
    return (low + high) / 2


def student_975(freedom):
    """By Simpson's rule over the density: unlike the program, which sums a series."""
    scale = math.exp(math.lgamma((freedom + 1) / 2) - math.lgamma(freedom / 2)) / math.sqrt(freedom * math.pi)

    def within(t, steps=4000):
        width = t / steps
        ends = [scale * (1 + (i * width) ** 2 / freedom) ** (-(freedom + 1) / 2) for i in range(steps + 1)]
        return width / 3 * (ends[0] + ends[-1] + 4 * sum(ends[1:-1:2]) + 2 * sum(ends[2:-1:2]))

    low, high = 1.9, 13.0  # of one degree of freedom: 12.7
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if within(middle) < 0.475 else (low, middle)
    return (low + high) / 2


LEVELS = {}


def level(blocks):
    if blocks not in LEVELS:
        LEVELS[blocks] = 0.5 * math.erfc(student_975(blocks - 1) * math.sqrt(blocks / (blocks - 1)) / math.sqrt(2))
    return LEVELS[blocks]


def garwood(events):
    def at_most(count, mean):
        return sum(math.exp(-mean) * mean**i / math.factorial(i) for i in range(int(count) + 1))

    low = solve(0, 100, lambda mean: 1 - at_most(events - 1, mean) < 0.025) if events else 0.0
    return low, solve(0, 100, lambda mean: at_most(events, mean) > 0.025)


DRAWS = {}


def draws(count):
    """Block indices of each replicate."""
    if count not in DRAWS:
        state, mask, found = SEED, 2**64 - 1, []
        for _ in range(2000):
            replicate = []
            for _ in range(count):
                state = (state + 0x9E3779B97F4A7C15) & mask
                z = state
                z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & mask
                z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & mask
                replicate.append(((z ^ (z >> 31)) * count) >> 64)
            found.append(replicate)
        DRAWS[count] = found
    return DRAWS[count]


def estimate(kind, sums):
    blocks = [sums[key] for key in sorted(sums)]
    total = [sum(block[0] for block in blocks), sum(block[1] for block in blocks)]
    count = sum(1 for block in blocks if block[1] > 0)

    def of(a, b):
        if b <= 0:
            return None
        return {"percent": 100 * a / b, "root": math.sqrt(max(a / b, 0))}.get(kind, a / b)

    value, interval = of(*total), None
    if value is None:
        return None, None, count
    if kind == "rate" and total[0] < 10:
        interval = tuple(events / total[1] for events in garwood(round(total[0])))
    elif count >= 5:
        if kind == "percent" and (total[0] <= 0 or total[0] >= total[1]):
            other = min(100 * garwood(0)[1] / count, 100)
            interval = (0.0, other) if total[0] <= 0 else (100 - other, 100.0)
        else:
            values = []
            for replicate in draws(len(blocks)):
                a = b = 0.0
                for index in replicate:
                    a += blocks[index][0]
                    b += blocks[index][1]
                if (one := of(a, b)) is not None:
                    values.append(one)
            if len(values) >= 1000:
                values.sort()
                weights = [block[1] for block in blocks]
                effective = int(sum(weights) ** 2 / sum(weight**2 for weight in weights) + 1e-6)
                if effective >= 2:
                    interval = quantile(values, level(effective)), quantile(values, 1 - level(effective))
    return value, interval, count


class Figures:
    def __init__(self):
        self.found = {}

    def plain(self, key, value, digits, count=None):
        self.found[key] = (value, None, digits, count, None)

    def estimated(self, key, kind, sums, digits, has_count=True):
        value, interval, blocks = estimate(kind, sums)
        count = int(sum(block[kind != "rate"] for block in sums.values()))
        self.found[key] = (value, interval, digits, count if has_count else None, blocks)


def add(sums, block, a, b):
    sums[block][0] += a
    sums[block][1] += b


def empty():
    return defaultdict(lambda: [0.0, 0.0])


# Recording


def packets(path):
    """Offsets of the payloads in a pcap of Ethernet, with times and contents."""
    octets = open(path, "rb").read()
    magic = struct.unpack("<I", octets[:4])[0]
    unit = {0xA1B2C3D4: 1000, 0xA1B23C4D: 1}[magic]
    place, found = 24, []
    while place + 16 <= len(octets):
        seconds, part, size, _ = struct.unpack("<IIII", octets[place : place + 16])
        start = place + 16 + 14 + 4 * (octets[place + 30] & 15) + 8
        found.append((start, place + 16 + size, seconds * NS + part * unit, octets[start : place + 16 + size]))
        place += 16 + size
    return found


def on_day(seconds, received):
    count = round(seconds * 128) * (NS // 128)
    midnight = received // (86400 * NS) * 86400 * NS
    return min((midnight + day * 86400 * NS + count for day in (-1, 0, 1)), key=lambda time: abs(time - received))


def holds_reports(payload):
    place = 0
    while place + 3 <= len(payload):
        size = int.from_bytes(payload[place + 1 : place + 3], "big")
        if payload[place] in (48, 129) and size >= 3:
            return True
        if size < 3:
            return False
        place += size
    return False


def read_sensors(site, capture, decoded, undulation):
    """Reports that the engine takes, by sensor, and records that are not used."""
    fusion = site["fusion"]
    window = fusion.get("window_s", 25) * NS
    future = min(fusion.get("max_future_s", 1), fusion.get("latency_s", 6.25)) * NS
    reports, refused = {sensor["id"]: [] for sensor in site["sensors"]}, Counter()
    sensors = {(48 if sensor["kind"] == "radar" else 129, sensor["sac"], sensor["sic"]): sensor for sensor in site["sensors"]}
    sent = packets(capture)
    starts = [packet[0] for packet in sent]
    copies, last = set(), {}
    for index, (_, _, time, payload) in enumerate(sent):
        if payload in last and time - last[payload] <= 2 * NS and holds_reports(payload):
            copies.add(index)
        else:
            last[payload] = time
    numbers = {}
    for line in decoded:
        if "error" in line or "sac" not in line:
            continue
        index = bisect.bisect_right(starts, line["block"]) - 1
        sensor, received = sensors.get((line["cat"], line["sac"], line["sic"])), sent[index][2]
        if sensor is None or index in copies:
            continue
        items = line["items"]
        time = on_day(items["140" if line["cat"] == 48 else "070"], received)
        if time - received > future or received - time > window:
            continue
        point = {"time": time, "received": received, "probability": None, "identity": None}
        if line["cat"] == 48:
            if items.get("020", {}).get("typ") == 0:
                continue
            point["place"] = radar_place(sensor, items, undulation)
            point["number"] = items["161"]["track_number"]
            octets = bytes.fromhex(items.get("SP", ""))
            octet = 1 + sensor["classification"].get("octet", 0)
            point["probability"] = octets[octet] / 255 if len(octets) > octet else None
        else:
            at = items["080"]
            unit = 180 / 2**31
            lat, lon = (round(at[key] / unit) * unit for key in ("latitude_deg", "longitude_deg"))
            point["place"] = (lat, lon, items["090"]["altitude_m"])
            point["identity"] = items["040"].strip()
            point["number"] = numbers.setdefault(point["identity"], len(numbers) + 1)
        reports[sensor["id"]].append(point)
    return reports


def radar_place(sensor, items, undulation):
    rho = round(items["040"]["rho_m"] * 256 / 1852) / 256 * 1852
    theta = round(items["040"]["theta_deg"] * 65536 / 360) * 360 / 65536
    azimuth = math.radians(theta + sensor.get("bearing_correction_deg", 0.0))
    lat, lon = math.radians(sensor["latitude_deg"]), math.radians(sensor["longitude_deg"])
    antenna = sensor["height_amsl_m"] + undulation
    measured = items.get("110")
    height = measured["height_m"] if measured else sensor.get("assumed_height_amsl_m", sensor["height_amsl_m"])
    radius = A * (1 - F) / (1 - E2 * math.sin(lat) ** 2)
    target, site = radius + height + undulation, radius + antenna
    sin = max(-1.0, min(1.0, ((target - site) * (target + site) - rho * rho) / (2 * rho * site)))
    ground = rho * math.sqrt(1 - sin * sin)
    east, north, up = ground * math.sin(azimuth), ground * math.cos(azimuth), rho * sin
    x, y, z = to_ecef(lat, lon, antenna)
    x += -math.sin(lon) * east - math.sin(lat) * math.cos(lon) * north + math.cos(lat) * math.cos(lon) * up
    y += math.cos(lon) * east - math.sin(lat) * math.sin(lon) * north + math.cos(lat) * math.sin(lon) * up
    z += math.cos(lat) * north + math.sin(lat) * up
    there = to_geodetic(x, y, z)
    return math.degrees(there[0]), math.degrees(there[1]), there[2] - undulation if measured else None


def read_picture(lines):
    points = []
    for line in lines:
        serial = line.get("uas_id", {}).get("serial_number")
        points.append({
            "time": stamp(line["time"]),
            "place": (line["lat"], line["lng"], line.get("alt_msl")),
            "number": line["track_number"],
            "source": line["source"],
            "identity": serial,
            "integrity": line.get("integrity"),
            "uncooperative": line.get("uncooperative", False),
        })
    return points


# Figures


class Subject:
    def __init__(self, key, kind, period_s, origin, limit, points, reference):
        self.key, self.kind, self.origin, self.limit, self.points = key, kind, origin, limit, points
        self.period = round(period_s * NS)
        self.gap = max(3 * self.period, 3 * NS)
        self.scored = reference.score(points)
        self.due, self.intervals = [], []
        by_drone = defaultdict(list)
        for point, slot, drone, _, _ in self.scored:
            if drone is not None:
                by_drone[drone].append(slot if kind == "picture" else point["time"])
        for drone, pieces in enumerate(reference.pieces):
            for first, last in pieces:
                if kind == "picture":
                    self.slots(reference, drone, first, last, set(by_drone[drone]))
                else:
                    self.span(drone, first * reference.slot_ns, (last + 1) * reference.slot_ns, sorted(by_drone[drone]))
        places = ((drone, time, made, reference.paths[drone].at(time)) for drone, time, made in self.due)
        self.due = [due for due in places if due[3] is not None]

    def slots(self, reference, drone, first, last, with_point):
        before = None
        for slot in range(first, last + 1):
            time = reference.centre(slot)
            self.due.append((drone, time, slot in with_point))
            if slot in with_point:
                if before is not None:
                    self.intervals.append((drone, time, time - before))
                before = time

    def span(self, drone, start, end, times):
        times = [time for time in times if start <= time < end]
        if not times:
            missed = range((end - start) // self.period)
            self.due += [(drone, start + self.period // 2 + k * self.period, False) for k in missed]
            return
        self.due += [(drone, times[0] - k * self.period, False) for k in range(1, (times[0] - start) // self.period + 1)]
        self.due.append((drone, times[0], True))
        before = times[0]
        for time in times[1:]:
            between = time - before
            periods = (2 * between + self.period) // (2 * self.period)
            if periods:
                self.due += [(drone, before + k * between // periods, False) for k in range(1, periods)]
                self.due.append((drone, time, True))
                self.intervals.append((drone, time, between))
                before = time
        self.due += [(drone, before + k * self.period, False) for k in range(1, (end - before) // self.period + 1)]


RANGES = [100, 250, 500, 1000, 2500, 5000, 10000, 25000, 50000]
HEIGHTS = [25, 50, 100, 250, 500, 1000, 2500, 5000]


def bins(values, widths, most):
    """Width and label of the bin of a value."""
    largest = max([value for value in values if value is not None], default=0.0)
    width = next((width for width in widths if largest < width * most), widths[-1])
    return lambda value: None if value is None else f"{math.floor(value / width) * width}-{(math.floor(value / width) + 1) * width}"


def detection(figures, reference, subject):
    rows = []
    for drone, time, made, place in subject.due:
        range_m = length(offset(place, subject.origin))
        if reference.covers(subject, drone) and (subject.limit is None or range_m <= subject.limit):
            rows.append((drone, time, made, range_m, place[2]))
    range_of, height_of = bins([r[3] for r in rows], RANGES, 10), bins([r[4] for r in rows], HEIGHTS, 8)
    groups = defaultdict(empty)
    for drone, time, made, range_m, height in rows:
        keys = ["all", f"range.{range_of(range_m)}"]
        if height is not None:
            keys.append(f"height.{height_of(height)}")
        if reference.is_truth and subject.kind != "receiver":
            keys.append("class.transponder" if drone in reference.equipped else "class.no-transponder")
        if motion := reference.paths[drone].motion(time):
            keys.append(f"motion.{motion}")
        if name := reference.classes.get(reference.ids[drone]):
            keys.append(f"class.{name}")
        for key in keys:
            add(groups[key], reference.block(drone, time), made, 1)
    for key, sums in groups.items():
        figures.estimated(f"{subject.key}.detection.{key}", "percent", sums, 1)


def intervals(figures, reference, subject):
    sums, gaps, lengths = empty(), reference.flown(3600, subject), []
    for drone, until, between in subject.intervals:
        block = reference.block(drone, until)
        add(sums, block, between / NS, 1)
        lengths.append(between / NS)
        if between > subject.gap:
            add(gaps, block, 1, 0)
    lengths.sort()
    key = f"{subject.key}.interval"
    figures.estimated(f"{key}.mean", "mean", sums, 2)
    figures.plain(f"{key}.p50", quantile(lengths, 0.5), 2, len(lengths))
    figures.plain(f"{key}.p95", quantile(lengths, 0.95), 2, len(lengths))
    figures.plain(f"{key}.longest", lengths[-1] if lengths else None, 2, len(lengths))
    figures.estimated(f"{key}.gaps", "rate", gaps, 1)


def accuracy(figures, reference, subject):
    rows = []
    for point, _, drone, truth, error in subject.scored:
        if drone is not None:
            rows.append((drone, point["time"], error, length(offset(truth, subject.origin)), truth[2]))
    range_of, height_of = bins([r[3] for r in rows], RANGES, 10), bins([r[4] for r in rows], HEIGHTS, 8)
    groups = defaultdict(empty)
    for drone, time, error, range_m, height in rows:
        block, flat = reference.block(drone, time), length(error)
        add(groups["horizontal.mean"], block, flat, 1)
        keys = ["", f".range.{range_of(range_m)}"]
        if error[2] is not None:
            add(groups["vertical.mean"], block, abs(error[2]), 1)
            add(groups["vertical.rms"], block, error[2] ** 2, 1)
        if height is not None:
            keys.append(f".height.{height_of(height)}")
        if name := reference.classes.get(reference.ids[drone]):
            keys.append(f".class.{name}")
        if reference.is_truth and subject.kind == "picture":
            keys.append(".class.transponder" if drone in reference.equipped else ".class.no-transponder")
        for key in keys:
            add(groups[f"horizontal.rms{key}"], block, flat**2, 1)
    for key, sums in groups.items():
        figures.estimated(f"{subject.key}.accuracy.{key}", "root" if ".rms" in key else "mean", sums, 1)
    flat = sorted(length(row[2]) for row in rows)
    for name, share in (("p50", 0.5), ("p95", 0.95)):
        figures.plain(f"{subject.key}.accuracy.horizontal.{name}", quantile(flat, share), 1, len(flat))


def tracking(figures, reference, subject):
    key = f"{subject.key}.tracking"
    by_drone, by_number = defaultdict(list), defaultdict(list)
    for point, slot, drone, _, _ in subject.scored:
        by_number[point["number"]].append((point["time"], drone))
        if drone is not None:
            by_drone[drone].append((point["time"], point["number"]))
    changes = reference.flown(60, subject)
    for drone, points in by_drone.items():
        moments, followed = defaultdict(list), None
        for time, number in points:
            moments[time].append(number)
        for time in sorted(moments):
            if followed not in moments[time]:
                if followed is not None:
                    add(changes, reference.block(drone, time), 1, 0)
                followed = moments[time][0]
    figures.estimated(f"{key}.changes", "rate", changes, 3)
    tracks = []
    for points in by_number.values():
        points.sort(key=lambda point: point[0])
        tracks.append([points[0]])
        for before, point in zip(points, points[1:]):
            if point[0] - before[0] > 25 * NS:
                tracks.append([])
            tracks[-1].append(point)
    swaps = reference.flown(3600, subject)
    for track in tracks:
        owned = [(time, drone) for time, drone in track if drone is not None]
        for (_, before), (time, drone) in zip(owned, owned[1:]):
            if before != drone:
                add(swaps, reference.block(drone, time), 1, 0)
    figures.estimated(f"{key}.swaps", "rate", swaps, 2)
    value, _, digits, count, _ = figures.found[f"{key}.swaps"]
    figures.plain(f"{key}.swaps", value, digits, count)
    if reference.is_truth:
        false = reference.run_time(3600)
        for track in tracks:
            if 2 * sum(1 for _, drone in track if drone is None) > len(track):
                add(false, (-1, reference.piece(track[0][0])), 1, 0)
        figures.estimated(f"{key}.false", "rate", false, 1)
    if reference.is_truth and subject.kind == "picture":
        time = reference.run_time(60)
        foreign = {(p["source"], p["number"], slot) for p, slot, drone, _, _ in subject.scored if drone is None}
        for _, _, slot in foreign:
            add(time, (-1, reference.piece(reference.centre(slot))), reference.slot_ns / NS, 0)
        figures.estimated(f"{key}.false-time", "mean", time, 2)
    firsts = []
    for drone, points in by_drone.items():
        firsts.append((min(points)[0] - reference.pieces[drone][0][0] * reference.slot_ns) / NS)
    firsts.sort()
    covered = sum(1 for drone, pieces in enumerate(reference.pieces) if pieces and reference.covers(subject, drone))
    figures.plain(f"{key}.found", float(len(firsts)), 0, covered)
    figures.plain(f"{key}.first", quantile(firsts, 0.5), 2, len(firsts))
    figures.plain(f"{key}.first-longest", firsts[-1] if firsts else None, 2, len(firsts))


def identification(figures, reference, picture, subjects):
    counts = defaultdict(Counter)
    for subject in subjects:
        if subject.kind == "receiver":
            for point, _, drone, _, _ in subject.scored:
                if drone is not None:
                    counts[drone][point["identity"]] += 1
    own = {drone: min(count, key=lambda name: (-count[name], name)) for drone, count in counts.items()}
    stated, wrong = empty(), empty()
    for point, _, drone, _, _ in picture.scored:
        if drone is None:
            continue
        block = reference.block(drone, point["time"])
        if drone in own:
            add(stated, block, point["identity"] is not None, 1)
        if point["identity"] is not None:
            add(wrong, block, own.get(drone) != point["identity"], 1)
    figures.estimated("picture.identity.stated", "percent", stated, 2)
    figures.estimated("picture.identity.wrong", "percent", wrong, 2)
    for subject in subjects:
        if subject.kind != "radar" or not reference.is_truth:
            continue
        drones, others = empty(), empty()
        for point, _, drone, _, _ in subject.scored:
            if point["probability"] is None:
                continue
            is_uav = point["probability"] >= 0.5
            if drone is None:
                add(others, (-1, reference.piece(point["time"])), not is_uav, 1)
            else:
                add(drones, reference.block(drone, point["time"]), is_uav, 1)
        figures.estimated(f"{subject.key}.class.drones", "percent", drones, 1)
        figures.estimated(f"{subject.key}.class.others", "percent", others, 1)


def alignment(figures, reference, subject):
    sums = {name: empty() for name in ("bearing", "range", "height", "clock")}
    for point, _, drone, truth, error in subject.scored:
        if drone is None:
            continue
        block = reference.block(drone, point["time"])
        if subject.kind == "radar":
            seen, real = offset(point["place"], subject.origin), offset(truth, subject.origin)
            turn = math.degrees(math.atan2(seen[0], seen[1]) - math.atan2(real[0], real[1]))
            add(sums["bearing"], block, (turn + 180) % 360 - 180, 1)
            add(sums["range"], block, length(seen) - length(real), 1)
        if error[2] is not None:
            add(sums["height"], block, error[2], 1)
        velocity = reference.paths[drone].velocity(point["time"])
        if velocity and math.hypot(*velocity) > 2:
            along = error[0] * velocity[0] + error[1] * velocity[1]
            add(sums["clock"], block, -along, velocity[0] ** 2 + velocity[1] ** 2)
    for name, digits in (("bearing", 3), ("range", 1), ("height", 1), ("clock", 3)):
        if sums[name]:
            figures.estimated(f"{subject.key}.alignment.{name}", "mean", sums[name], digits, name != "clock")


def latency(figures, subject):
    delays = sorted((point["received"] - point["time"]) / NS for point in subject.points)
    if not delays:
        return
    key, count = f"{subject.key}.latency", len(delays)
    for name, share in (("p50", 0.5), ("p95", 0.95), ("p99", 0.99), ("longest", 1.0)):
        figures.plain(f"{key}.{name}", quantile(delays, share), 3, count)
    figures.plain(f"{key}.early", 100 * sum(1 for delay in delays if delay < 0) / count, 2, count)


def integrity(figures, reference, points):
    assessed = {point["identity"] for point in points if point["identity"] and point["integrity"]}
    flagged = defaultdict(set)
    for point in points:
        if point["identity"] and point["integrity"] in ("suspect", "failed"):
            flagged[point["identity"]].add(point["time"])
    key = "picture.integrity"
    figures.plain(f"{key}.assessed", float(len(assessed)), 0)
    figures.plain(f"{key}.flagged", float(len(flagged)), 0)
    figures.plain(f"{key}.uncooperative", float(len({p["number"] for p in points if p["uncooperative"]})), 0)
    for name, times in flagged.items():
        figures.plain(f"{key}.time.{name}", len(times) * reference.slot_ns / NS, 2)


def compute(capture, site_file, decoded_file, picture_file, truth_file):
    site = tomllib.load(open(site_file, "rb"))
    lines = [json.loads(line) for line in open(decoded_file)]
    picture_lines = [json.loads(line) for line in open(picture_file)]
    undulation = site["site"].get("geoid_undulation_m")
    if undulation is None:
        undulation = picture_lines[0]["geoid_separation"]
    reports = read_sensors(site, capture, lines, undulation)
    picture = read_picture(picture_lines)
    slot_ns = round(site["fusion"].get("slot_s", 0.25) * NS)
    samples, classes = defaultdict(list), {}
    if truth_file:
        for row in csv.DictReader(open(truth_file)):
            height = float(row["alt_msl"]) if row["alt_msl"] else None
            samples[row["id"]].append((stamp(row["time"]), (float(row["lat"]), float(row["lon"]), height)))
            if row.get("class"):
                classes.setdefault(row["id"], row["class"])
    else:
        for point in (point for points in reports.values() for point in points if point["identity"]):
            samples[point["identity"]].append((point["time"], point["place"]))
    paths = {name: Path(of) for name, of in samples.items()}
    reference = Reference(paths, slot_ns, bool(truth_file), classes)
    radar = next(sensor for sensor in site["sensors"] if sensor["kind"] == "radar")
    origin = (radar["latitude_deg"], radar["longitude_deg"], radar["height_amsl_m"])
    subjects = []
    for sensor in site["sensors"]:
        is_radar = sensor["kind"] == "radar"
        at = (sensor["latitude_deg"], sensor["longitude_deg"], sensor["height_amsl_m"]) if is_radar else origin
        period = sensor.get("period_s", 0.25 if is_radar else 2.0)
        kind = "radar" if is_radar else "receiver"
        limit = sensor.get("max_range_m")
        subjects.append(Subject(f"sensor.{sensor['id']}", kind, period, at, limit, reports[sensor["id"]], reference))
    for subject in subjects:
        if subject.kind == "receiver":
            reference.equipped |= {drone for _, _, drone, _, _ in subject.scored if drone is not None}
    shown = Subject("picture", "picture", slot_ns / NS, origin, None, picture, reference)
    figures = Figures()
    received = [packet[2] for packet in packets(capture)]
    figures.plain("recording.length", (max(received) - min(received)) / NS, 1)
    figures.plain("recording.aircraft", float(reference.aircraft), 0)
    figures.plain("recording.flown", sum(block[1] for block in reference.flown(3600).values()), 3)
    figures.plain("picture.points", float(len(picture)), 0)
    for name, points in reports.items():
        figures.plain(f"sensor.{name}.reports", float(len(points)), 0)
    judged = [s for s in subjects if s.points and (reference.is_truth or s.kind != "receiver")] + [shown]
    for subject in judged:
        detection(figures, reference, subject)
        tracking(figures, reference, subject)
        accuracy(figures, reference, subject)
        if subject.kind != "picture":
            alignment(figures, reference, subject)
    for subject in {id(s): s for s in judged + [s for s in subjects if s.kind == "receiver"]}.values():
        intervals(figures, reference, subject)
    identification(figures, reference, shown, subjects)
    for subject in subjects:
        latency(figures, subject)
    integrity(figures, reference, picture)
    return figures.found


def compare(report, found):
    """Differences, and the number of printed numbers that were compared."""
    differences, compared, seen = [], 0, set()
    for section in report["sections"]:
        for figure in (figure for table in section["tables"] for figure in table["figures"]):
            key = figure["key"]
            seen.add(key)
            if ".registration." in key or key.startswith("refused."):
                continue
            if key not in found:
                differences.append(f"{key}: is not computed")
                continue
            value, interval, digits, count, blocks = found[key]
            low, high = interval or (None, None)
            for name, own in (("value", value), ("low", low), ("high", high)):
                own = None if own is None else float(f"{own:.{digits}f}")
                compared += own is not None
                if own != figure.get(name):
                    differences.append(f"{key}: {name} is {figure.get(name)}, and computed {own}")
            for name, own in (("count", count), ("blocks", blocks)):
                compared += own is not None
                if own != figure.get(name):
                    differences.append(f"{key}: {name} is {figure.get(name)}, and computed {own}")
    differences += [f"{key}: is not in the report" for key in found if key not in seen]
    return differences, compared


def main():
    report, *files = sys.argv[1:]
    found = compute(*files, *[None] * (5 - len(files)))
    differences, compared = compare(json.load(open(report)), found)
    for difference in differences:
        print(difference)
    print(f"{len(differences)} differences, {compared} printed numbers compared")
    sys.exit(1 if differences else 0)


if __name__ == "__main__":
    main()
