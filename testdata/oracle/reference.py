#!/usr/bin/env python3
"""The `reference` profile of the fusion, written to be read and not to be fast.

    python3 reference.py CAPTURE.pcap --config SITE.toml -o EXPECTED.csv

Reads the UDP datagrams of a capture (CAT048 plots, CAT129 transponder reports) and writes every output point with an
unrounded position. Nothing is kept between two slots but the reports, the numbers given and the clock: each slot is
computed anew from its window. Geodesy is PROJ's, interpolation SciPy's.

Units: metres, radians, counts of 1/128 s since the Unix epoch for report times, whole microseconds for reception times.
"""

import argparse
import csv
import math
import struct
import sys
import tomllib
from collections import Counter, defaultdict
from dataclasses import dataclass, field

import numpy as np
from pyproj import Geod, Transformer
from scipy.interpolate import PchipInterpolator

TICKS = 128                # per second: resolution of a time of day on the wire
SLOT = 32                  # ticks in a slot of 0.25 s
SLOT_US = 250_000
DAY = 86_400
PAST, AHEAD = 75, 24       # the window of slot k: k - 75 ... k + 24
LATENCY = 25               # slot k is emitted when slot k + 25 opens
DUPLICATE_US = 2_000_000
JUMP_US = 25_000_000
NAUTICAL_MILE = 1852.0
FOOT = 0.3048


# --- ASTERIX ---------------------------------------------------------------------------------------------------------

class BadRecord(Exception):
    """A record that cannot be read to its end; its block ends with it."""


def fixed(length):
    return lambda octets, at: at + length


def extended(octets, at):
    """Octets, each announcing another by its lowest bit."""
    while octet(octets, at, "item runs past the end") & 1:
        at += 1
    return at + 1


def repeated(length):
    return lambda octets, at: at + 1 + length * octet(octets, at, "no repetition count")


def explicit(octets, at):
    """SP and RE: the first octet counts itself."""
    length = octet(octets, at, "no length")
    if length == 0:
        raise BadRecord("length 0")
    return at + length


def compound(*subfields):
    """One primary octet announces up to seven subfields; None is a reserved one."""
    def end(octets, at):
        primary = octet(octets, at, "item runs past the end")
        if primary & 1:
            raise BadRecord("primary subfield extended")
        at += 1
        for bit, subfield in enumerate(subfields):
            if primary & 0x80 >> bit:
                if subfield is None:
                    raise BadRecord("reserved subfield")
                at = subfield(octets, at)
        return at
    return end


def octet(octets, at, otherwise):
    if at >= len(octets):
        raise BadRecord(otherwise)
    return octets[at]


ONE = fixed(1)
TWO = fixed(2)
UAP = {
    34: [("010", TWO), ("000", ONE), ("030", fixed(3)), ("020", ONE), ("041", TWO),
         ("050", compound(ONE, None, None, ONE, ONE, TWO, None)),
         ("060", compound(ONE, None, None, ONE, ONE, ONE, None)),
         ("070", repeated(2)), ("100", fixed(8)), ("110", ONE), ("120", fixed(8)), ("090", TWO),
         ("RE", explicit), ("SP", explicit)],
    48: [("010", TWO), ("140", fixed(3)), ("020", extended), ("040", fixed(4)), ("070", TWO), ("090", TWO),
         ("130", compound(*[ONE] * 7)), ("220", fixed(3)), ("240", fixed(6)), ("250", repeated(8)), ("161", TWO),
         ("042", fixed(4)), ("200", fixed(4)), ("170", extended), ("210", fixed(4)), ("030", extended), ("080", TWO),
         ("100", fixed(4)), ("110", TWO), ("120", compound(TWO, repeated(6), None, None, None, None, None)),
         ("230", TWO), ("260", fixed(7)), ("055", ONE), ("050", TWO), ("065", ONE), ("060", TWO),
         ("SP", explicit), ("RE", explicit)],
}


def uap129(risk_length):
    """CAT129; the length of I129/120 is 1 or 3, as the edition contradicts itself."""
    return [("010", TWO), ("015", TWO), ("020", fixed(3)), ("030", fixed(3)), ("040", fixed(12)), ("050", TWO),
            ("070", fixed(3)), ("080", fixed(8)), ("090", fixed(3)), ("100", fixed(3)), ("110", TWO),
            ("120", fixed(risk_length)), ("SP", explicit), ("185", fixed(5)), ("220", fixed(3))]


def read_record(uap, octets, at):
    """The items of the record at `at`, as octets, and where it ends."""
    frns, frn, more = [], 0, 1
    while more:
        mask = octet(octets, at, "FSPEC runs past the end")
        frns += [frn + bit for bit in range(7) if mask & 0x80 >> bit]
        frn, more, at = frn + 7, mask & 1, at + 1
    items = {}
    for frn in frns:
        if frn >= len(uap):
            raise BadRecord("reserved FRN")
        name, end_of = uap[frn]
        end = end_of(octets, at)
        if end > len(octets):
            raise BadRecord("item runs past the end")
        items[name] = octets[at:end]
        at = end
    return items, at


def read_records(uap, octets):
    """The good records of a block up to the first bad one, and what was bad with that."""
    records, at = [], 0
    try:
        while at < len(octets):
            record, at = read_record(uap, octets, at)
            records.append(record)
    except BadRecord as bad:
        return records, str(bad)
    return records, None


def read_datagram(datagram, counts):
    """(category, record) for each good record of a datagram."""
    at = 0
    while at < len(datagram):
        if at + 3 > len(datagram):
            counts["LEN past the end"] += 1
            return
        category, length = struct.unpack_from(">BH", datagram, at)
        if length < 3:
            counts["LEN below 3"] += 1
            return
        if at + length > len(datagram):
            counts["LEN past the end"] += 1
            return
        block = datagram[at + 3:at + length]
        at += length
        if category == 129:
            records, bad = read_records(uap129(1), block)
            if bad:
                with_three = read_records(uap129(3), block)
                records, bad = with_three if with_three[1] is None else (records, bad)
        elif category in UAP:
            records, bad = read_records(UAP[category], block)
        else:
            counts[f"skipped category {category}"] += 1
            continue
        for record in records:
            yield category, record
        if bad:
            counts[bad] += 1


def unsigned(octets):
    return int.from_bytes(octets, "big")


def signed(octets):
    return int.from_bytes(octets, "big", signed=True)


def read_capture(path):
    """(reception time in microseconds, UDP payload) for each UDP datagram of an Ethernet pcap, VLAN tags not known."""
    with open(path, "rb") as file:
        data = file.read()
    order, unit = {b"\xd4\xc3\xb2\xa1": ("<", 1), b"\xa1\xb2\xc3\xd4": (">", 1),
                   b"\x4d\x3c\xb2\xa1": ("<", 1000), b"\xa1\xb2\x3c\x4d": (">", 1000)}[data[:4]]
    at = 24
    while at + 16 <= len(data):
        seconds, fraction, captured, _ = struct.unpack_from(order + "4I", data, at)
        frame = data[at + 16:at + 16 + captured]
        at += 16 + captured
        if len(frame) < 42 or frame[12:14] != b"\x08\x00" or frame[23] != 17:
            continue
        udp = 14 + 4 * (frame[14] & 15)
        length = unsigned(frame[udp + 4:udp + 6])
        yield seconds * 1_000_000 + fraction // unit, frame[udp + 8:udp + length]


# --- geometry --------------------------------------------------------------------------------------------------------

class Frame:
    """East, north, up at a point of the ellipsoid, to and from longitude, latitude (degrees) and ellipsoidal height."""

    def __init__(self, latitude, longitude, height):
        self.pipeline = Transformer.from_pipeline(
            "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad +step +proj=cart +ellps=WGS84 "
            f"+step +proj=topocentric +ellps=WGS84 +lon_0={longitude!r} +lat_0={latitude!r} +h_0={height!r}")

    def enu(self, latitude, longitude, height):
        return np.array(self.pipeline.transform(longitude, latitude, height))

    def geodetic(self, enu):
        longitude, latitude, height = self.pipeline.transform(*map(float, enu), direction="INVERSE")
        return latitude, longitude, height


def mean_radius(latitude):
    """Gaussian mean radius of WGS-84 at a latitude in degrees: sqrt(M N')."""
    geod = Geod(ellps="WGS84")
    w2 = 1 - geod.es * math.sin(math.radians(latitude)) ** 2
    return geod.a * math.sqrt(1 - geod.es) / w2


def polar_to_enu(slant_range, azimuth, height, radius, radar_height):
    """Position about the radar of a plot (metres, radians) whose ellipsoidal height is known."""
    up_to_target, up_to_radar = radius + height, radius + radar_height
    sine = ((up_to_target - up_to_radar) * (up_to_target + up_to_radar) - slant_range ** 2) / (
        2 * slant_range * up_to_radar)
    sine = max(-1.0, min(1.0, sine))
    ground = slant_range * math.sqrt(1 - sine * sine)
    return np.array([ground * math.sin(azimuth), ground * math.cos(azimuth), slant_range * sine])


# --- reports ---------------------------------------------------------------------------------------------------------

@dataclass
class Fix:
    """A transponder report: time in ticks, position in the frame of the site."""
    ticks: int
    enu: np.ndarray


@dataclass
class Plot:
    """A radar detection: time in ticks, position in the frame of the site, slant range in metres."""
    ticks: int
    enu: np.ndarray
    slant_range: float
    has_height: bool
    probable: bool          # UAV probability known and above 0


@dataclass
class Radar:
    order: int
    settings: dict
    frame: Frame
    radius: float
    height: float           # ellipsoidal


@dataclass
class Window:
    """What the reports of slots k - 75 ... k + 24 say; index 0 is slot k - 75."""
    points: dict            # identity -> array (slots, 3), NaN where not interpolated
    detections: dict        # radar track -> {index: Plot}
    associated: dict = field(default_factory=dict)   # (radar track, identity) -> array of bool over slots


class Drop(Exception):
    """A record left out; its text is the reason that is counted."""


class Fusion:
    def __init__(self, site):
        self.site, self.counts, self.output = site, Counter(), []
        fusion = site.get("fusion", {})
        self.max_future = fusion.get("max_future_s", 1.0)
        self.max_gap = fusion.get("max_gap_s", 25.0)
        self.threshold = np.array(fusion.get("threshold_m", [[0, 60], [333.33, 60], [4333.33, 300]]), float)
        self.ratio_per_mille = round(1000 * fusion.get("ratio_min", 0.9))
        self.min_samples = fusion.get("min_samples", 4)
        self.weights = fusion.get("weight_radar", 1.0), fusion.get("weight_transponder", 10.0)
        self.radar_only_min = fusion.get("radar_only_min_s", 8.0)
        self.suppress = round(fusion.get("suppress_s", 4.0) * 4)
        self.configured = {serial.encode(): n for serial, n in fusion.get("transponder_numbers", {}).items()}
        if any(area["kind"] == "mask" for area in site.get("areas", [])):
            sys.exit("masks are not part of this script")

        self.undulation = site["site"]["geoid_undulation_m"]
        self.radars, self.transponders = {}, set()
        for sensor in site["sensors"]:
            key = sensor["sac"], sensor["sic"]
            if sensor["kind"] == "transponder":
                self.transponders.add(key)
                continue
            height = sensor["height_amsl_m"] + self.undulation
            frame = Frame(sensor["latitude_deg"], sensor["longitude_deg"], height)
            self.radars[key] = Radar(len(self.radars), sensor, frame, mean_radius(sensor["latitude_deg"]), height)
        self.radar_list = list(self.radars.values())
        self.frame = self.radar_list[0].frame

        self.now = None                     # the engine's time: running maximum of reception times
        self.next_slot = None
        self.handled = {}                   # octets of a datagram -> reception time of the copy handled
        self.fixes = defaultdict(dict)      # identity -> {ticks: Fix}
        self.plots = defaultdict(dict)      # (radar order, track) -> {slot: Plot}
        self.numbers = {}                   # identity -> number

    # reception

    def receive(self, reception, datagram):
        self.advance(reception)
        handled = self.handled.get(datagram)
        if handled is not None and abs(reception - handled) <= DUPLICATE_US:
            self.counts["identical datagram"] += 1
            return
        self.handled[datagram] = reception
        for category, record in read_datagram(datagram, self.counts):
            try:
                self.take(category, record, reception)
            except Drop as drop:
                self.counts[str(drop)] += 1

    def advance(self, reception):
        """Emits every slot that is due before this reception."""
        first_open = reception // SLOT_US - LATENCY + 1
        if self.now is None:
            self.now, self.next_slot = reception, first_open
            return
        while self.next_slot < first_open:
            self.emit()
        if reception - self.now > JUMP_US:
            self.counts["jump"] += 1
            self.fixes.clear()
            self.plots.clear()
        self.now = max(self.now, reception)

    def finish(self):
        """Emits up to the last slot that holds a report."""
        slots = [ticks // SLOT for fixes in self.fixes.values() for ticks in fixes]
        slots += [slot for plots in self.plots.values() for slot in plots]
        while slots and self.next_slot <= max(slots):
            self.emit()

    # records

    def take(self, category, record, reception):
        if category == 34:
            self.counts["CAT034"] += 1
        elif category == 48:
            self.take_plot(record, reception)
        else:
            self.take_fix(record, reception)

    def time_of(self, item, reception):
        """Ticks since the epoch, on the day that puts the report nearest to its reception."""
        time_of_day = unsigned(item)
        if time_of_day > DAY * TICKS:
            raise Drop("time of day above 24 h")
        day = round((reception / 1e6 - time_of_day / TICKS) / DAY)
        ticks = day * DAY * TICKS + time_of_day
        if ticks / TICKS - reception / 1e6 > self.max_future:
            raise Drop("future")
        if ticks // SLOT < self.next_slot - PAST:
            raise Drop("late")
        return ticks

    def take_plot(self, record, reception):
        if "010" not in record:
            raise Drop("CAT048 without 010")
        radar = self.radars.get(tuple(record["010"]))
        if radar is None:
            raise Drop("CAT048 of an unknown source")
        for item in ("140", "040", "161"):
            if item not in record:
                raise Drop(f"CAT048 without {item}")
        descriptor = record.get("020")
        if descriptor and descriptor[0] >> 5 == 0:
            raise Drop("TYP 0")
        if descriptor and descriptor[0] & 0x10:
            raise Drop("SIM")
        if len(descriptor or b"") > 1 and descriptor[1] & 0x80:
            raise Drop("TST")
        counts_of_range, counts_of_azimuth = struct.unpack(">HH", record["040"])
        if counts_of_range == 0:
            raise Drop("slant range 0")
        ticks = self.time_of(record["140"], reception)
        self.counts["plots"] += 1

        settings = radar.settings
        has_height = "110" in record
        if has_height:
            # two spare bits, then 14 bits two's complement of 25 ft
            counts_of_height = (unsigned(record["110"]) & 0x3FFF ^ 0x2000) - 0x2000
            height_amsl = counts_of_height * 25 * FOOT
        else:
            height_amsl = settings["assumed_height_amsl_m"]
        slant_range = counts_of_range * NAUTICAL_MILE / 256
        azimuth = math.radians(counts_of_azimuth * 360 / 65536 + settings.get("bearing_correction_deg", 0.0))
        enu = polar_to_enu(slant_range, azimuth, height_amsl + self.undulation, radar.radius, radar.height)
        if radar.order > 0:
            enu = self.frame.enu(*radar.frame.geodetic(enu))
        plot = Plot(ticks, enu, slant_range, has_height, self.probable(settings["classification"], record))
        track = radar.order, unsigned(record["161"]) & 0x0FFF
        kept = self.plots[track].get(ticks // SLOT)
        if kept is None or ticks >= kept.ticks:
            self.plots[track][ticks // SLOT] = plot

    @staticmethod
    def probable(classification, record):
        """Whether the plot's UAV probability is known and above 0."""
        if classification["source"] == "constant":
            return classification["value"] > 0
        if classification["source"] == "target-classification":
            codes = {value >> 1 for value in record.get("030", b"")}
            return not codes & {5, 6, 7, 19, 20, 23}
        octets = record.get("SP", b"")[1:]
        index = classification.get("octet", 0)
        return index < len(octets) and octets[index] > 0

    def take_fix(self, record, reception):
        if "010" not in record:
            raise Drop("CAT129 without 010")
        if tuple(record["010"]) not in self.transponders:
            raise Drop("CAT129 of an unknown source")
        for item in ("070", "080"):
            if item not in record:
                raise Drop(f"CAT129 without {item}")
        serial = record.get("040", b"").strip(b" \0")
        if not serial:
            raise Drop("no identity")
        if "090" not in record:
            raise Drop("no height")
        latitude, longitude = struct.unpack(">ii", record["080"])
        if abs(latitude) > 1 << 29 or abs(longitude) > 1 << 30:
            raise Drop("position out of range")
        ticks = self.time_of(record["070"], reception)
        self.counts["fixes"] += 1
        identity = serial, record.get("050", b"").strip(b" \0")
        height = signed(record["090"]) / 10 + self.undulation
        degrees = 180 / (1 << 30)
        self.fixes[identity][ticks] = Fix(ticks, self.frame.enu(latitude * degrees, longitude * degrees, height))

    # emission

    def emit(self):
        slot = self.next_slot
        self.next_slot += 1
        window = self.window(slot)
        self.associate(window)
        for identity in sorted(window.points):
            if not np.isnan(window.points[identity][PAST, 0]):
                self.number(identity)
        self.put_out(slot, window)

    def window(self, slot):
        first, last = slot - PAST, slot + AHEAD
        centres = (np.arange(first, last + 1) - first) * SLOT / TICKS + SLOT / TICKS / 2
        points = {}
        for identity, fixes in self.fixes.items():
            knots = [fixes[ticks] for ticks in sorted(fixes) if first <= ticks // SLOT <= last]
            if len(knots) >= 2:
                times = np.array([(knot.ticks - first * SLOT) / TICKS for knot in knots])
                points[identity] = self.interpolate(times, np.array([knot.enu for knot in knots]), centres)
        detections = {}
        for track, plots in self.plots.items():
            inside = {s - first: plot for s, plot in plots.items() if first <= s <= last}
            if inside:
                detections[track] = inside
        return Window(points, detections)

    def interpolate(self, times, knots, centres):
        """Positions at the slot centres, NaN outside the knots and inside gaps that are too long."""
        values = PchipInterpolator(times, knots, extrapolate=False)(centres)
        for before, after in zip(times, times[1:]):
            if after - before > self.max_gap:
                values[(centres > before) & (centres < after)] = np.nan
        return values

    def associate(self, window):
        slots = PAST + 1 + AHEAD
        for track, detections in window.detections.items():
            index = np.array(sorted(detections))
            plots = [detections[i] for i in index]
            enu = np.array([plot.enu for plot in plots])
            dimensions = np.array([[1, 1, plot.has_height] for plot in plots], float)
            limit = np.interp([plot.slant_range for plot in plots], *self.threshold.T)
            for identity, points in window.points.items():
                distance = np.sqrt(((points[index] - enu) ** 2 * dimensions).sum(axis=1))
                co_present, within = np.zeros((2, slots), bool)
                co_present[index] = ~np.isnan(distance)
                within[index] = distance <= limit       # false where NaN
                present, close = co_present.cumsum(), within.cumsum()
                window.associated[track, identity] = (
                    within & (1000 * close >= self.ratio_per_mille * present) & (present >= self.min_samples))

    def put_out(self, slot, window):
        fused, radar, transponder = [], [], []
        pairs = [pair for pair, associated in window.associated.items() if associated[PAST]]
        for track, identity in pairs:
            plot, point = window.detections[track][PAST], window.points[identity][PAST]
            of_radar, of_transponder = self.weights
            enu = (of_radar * plot.enu + of_transponder * point) / (of_radar + of_transponder)
            if not plot.has_height:
                enu[2] = point[2]
            number = self.numbers[identity]
            fused.append((number * 10000 + track[1], track[0], track[1], number, enu, True))

        fused_tracks = {track for track, _ in pairs}
        for track, detections in window.detections.items():
            plot = detections.get(PAST)
            if plot is None or track in fused_tracks:
                continue
            probable = sum(1 for index, seen in detections.items() if index <= PAST and seen.probable)
            period = self.radar_list[track[0]].settings.get("period_s", 0.25)
            if probable * max(0.25, period) > self.radar_only_min:
                radar.append((track[1], track[0], track[1], "", plot.enu, plot.has_height))

        around = slice(PAST - self.suppress, PAST + self.suppress + 1)
        suppressed = {identity for (_, identity), associated in window.associated.items() if associated[around].any()}
        for identity, points in window.points.items():
            if identity not in suppressed and not np.isnan(points[PAST, 0]):
                number = self.numbers[identity]
                transponder.append((number, 0, "", number, points[PAST], True))

        for kind, lines in ("fused", fused), ("radar", radar), ("transponder", transponder):
            for number, _, track, own, enu, has_height in sorted(lines, key=lambda line: line[:2]):
                latitude, longitude, height = self.frame.geodetic(enu)
                self.output.append((
                    slot, f"{slot / 4 + 0.125:.3f}", kind, number, track, own, f"{latitude:.9f}", f"{longitude:.9f}",
                    f"{height - self.undulation:.3f}" if has_height else ""))

    def number(self, identity):
        """Gives the identity its number when it has none yet."""
        if identity in self.numbers:
            return
        serial, taken = identity[0], set(self.numbers.values())
        reserved = set(self.configured.values())
        number = self.configured.get(serial)
        if number is None or number in taken:
            number = int(serial) if serial.isdigit() else 0
            if not 1 <= number <= 429_496 or number in taken | reserved:
                number = next(n for n in range(1, 429_497) if n not in taken | reserved)
        self.numbers[identity] = number


def main():
    parser = argparse.ArgumentParser(description="Expected output of the reference profile for a capture.")
    parser.add_argument("capture")
    parser.add_argument("--config", required=True, help="site.toml")
    parser.add_argument("-o", "--output", required=True, help="expected.csv to write")
    arguments = parser.parse_args()
    with open(arguments.config, "rb") as file:
        fusion = Fusion(tomllib.load(file))
    for reception, datagram in read_capture(arguments.capture):
        fusion.receive(reception, datagram)
    fusion.finish()
    with open(arguments.output, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow("slot time kind number radar_track transponder lat lon alt_msl".split())
        writer.writerows(fusion.output)
    print(len(fusion.output), "points", dict(Counter(line[2] for line in fusion.output)))
    print(dict(fusion.counts))


if __name__ == "__main__":
    main()
