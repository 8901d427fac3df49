#!/usr/bin/env python3
"""Reads CAT062, CAT063 and CAT065 of the service with libasterix, a codec made by others from the same specifications, and compares the
tracks value by value with the same picture as NDJSON.

    pip install libasterix==0.36.3
    python3 system_tracks.py [--binary PROGRAM] [--tshark]

Of the flights in testdata, in both profiles: `replay --output-format cat062` writes a file, which is parsed strictly, and `replay --udp`
sends to a socket of this script on 127.0.0.1 what must be the same tracks, with the sensors and the status. `--tshark` has Wireshark's
reader go through `cat062-pcap` too, and compares its positions. Ends with 1 where anything disagrees.
"""

import argparse
import collections
import json
import os
import socket
import subprocess
import sys
import tempfile
import threading

from asterix import base
from asterix.generated import Cat_062_1_21, Cat_063_1_7, Cat_065_1_6

HERE = os.path.dirname(os.path.abspath(__file__))
TESTDATA = os.path.join(HERE, "..")
FLIGHTS = ["demo", "three-radars", "conformance/bias", "conformance/crossing", "conformance/hostile"]
CATEGORIES = {62: Cat_062_1_21, 63: Cat_063_1_7, 65: Cat_065_1_6}
FOOT = 0.3048

tally = collections.Counter()
wrong = []


def records(octets):
    """The category and the record of each record."""
    while octets:
        # One at a time: libasterix reads the next block by recursion.
        length = int.from_bytes(octets[1:3], "big")
        blocks = base.RawDatablock.parse(base.Bits.from_bytes(octets[:length]))
        octets = octets[length:]
        if isinstance(blocks, ValueError):
            raise blocks
        (block,) = blocks
        category = block.get_category()
        parsed = CATEGORIES[category].cv_uap.parse(block.get_raw_records())
        if isinstance(parsed, ValueError):
            raise parsed
        tally[f"CAT{category:03} records"] += len(parsed)
        yield from ((category, record) for record in parsed)


def value(record, item, *names, raw=False):
    """An item, or the part of it that the names lead to; `None` where it is not there."""
    found = record.get_item(item)
    for name in names:
        if found is None:
            return None
        try:
            found = found.variation.get_item(name)
        except KeyError:
            return None
    if found is None:
        return None
    content = getattr(found.variation, "content", None)
    if raw or not hasattr(content, "as_quantity"):
        return found.as_uint()
    return content.as_quantity()


def text(record, *path):
    bits = value(record, *path, raw=True)
    if bits is None:
        return None
    codes = [bits >> shift & 63 for shift in range(42, -1, -6)]
    return "".join(chr(code + 64) if code < 32 else chr(code) for code in codes).rstrip()


def check(what, is_right, *about):
    tally["values"] += 1
    if not is_right:
        wrong.append((what, *about))


def near(what, said, known, within, line):
    """Both are there or both are not, and no farther apart than that."""
    check(what, (said is None) == (known is None) and (said is None or abs(said - known) <= within), said, known, line)


def track_values(record, track, profile):
    """What a record of CAT062 says, beside the line of the same track."""
    midnight = track["time"][11:-1].split(":")
    seconds = int(midnight[0]) * 3600 + int(midnight[1]) * 60 + float(midnight[2])
    near("070", value(record, "070"), seconds, 1 / 256 + 0.0005, track)
    half = 180 / 2**26 + 1e-9
    near("105 latitude", value(record, "105", "LAT"), track["lat"], half, track)
    near("105 longitude", value(record, "105", "LON"), track["lng"], half, track)
    altitude = value(record, "130")
    near("130", None if altitude is None else altitude * FOOT, track.get("alt"), 6.25 * FOOT / 2 + 0.001, track)
    climb = value(record, "220")
    near("220", None if climb is None else climb * FOOT / 60, track.get("vertical_speed"), 6.25 * FOOT / 120 + 0.051, track)
    east, north = value(record, "185", "VX"), value(record, "185", "VY")
    speed = None if east is None else (east**2 + north**2) ** 0.5
    near("185", speed, track.get("speed"), 0.18 + 0.051, track)
    # Deviations are rounded up, so the circle of 95 % that the line states is no larger than these make it.
    sigma = value(record, "500", "APC", "X"), value(record, "500", "APC", "Y")
    check("500", (sigma[0] is None) == (profile == "reference"), track)
    if sigma[0] is not None:
        check("500 APC", track["accuracy_h_m"] <= 2.4478 * max(max(sigma), (sigma[0] ** 2 + sigma[1] ** 2) ** 0.5) + 0.01, sigma, track)
    is_mono = track["source"] != "fused"
    check("080 MON", value(record, "080", "MON") == is_mono, track)
    surveillance = {"fused": 0, "transponder": 1, "radar": 2}[track["source"]]
    check("080 SDS", value(record, "080", "SDS") == surveillance, track)
    source = 0 if "alt" not in track else 2 if track["source"] == "radar" else 1
    check("080 SRC", value(record, "080", "SRC") == source, track)
    check("080 AFF", value(record, "080", "AFF") == (track.get("integrity") in ("suspect", "failed")), track)
    serial = track.get("uas_id", {}).get("serial_number", "").strip()[-8:]
    named = serial if serial and all(c in "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789 " for c in serial) else None
    check("245", text(record, "245", "CHR") == named, track)
    check("380 ID", text(record, "380", "ID") == named, track)
    kinds = {part["kind"] for part in track["contributors"]}
    check("290 PSR", (value(record, "290", "PSR") is not None) == ("radar" in kinds), track)


def file_of(records_, lines, profile):
    """The records of a file beside the lines of NDJSON; every track has one number while it lasts, and no two have one."""
    alive = {}
    lines = iter(lines)
    for category, record in records_:
        check("category", category == 62)
        number = value(record, "040", raw=True)
        if value(record, "080", "TSE"):
            check("TSE", alive.pop(number, None) is not None, number)
            continue
        track = json.loads(next(lines))
        before = alive.get(number)
        check("040", before == (None if value(record, "080", "TSB") else track["id"]), before, track)
        alive[number] = track["id"]
        track_values(record, track, profile)
    check("lines", next(lines, None) is None)


def replayed(binary, flight, profile, *arguments, **environment):
    command = [binary, "replay", f"{TESTDATA}/{flight}/capture.pcap", "--config", f"{TESTDATA}/{flight}/site.toml"]
    done = subprocess.run([*command, "--profile", profile, *arguments], capture_output=True, env=os.environ | environment, check=False)
    assert done.returncode in (0, 2), done.stderr.decode()
    return done.stdout


def sent(binary, flight, profile):
    """The datagrams that `replay --udp` sends."""
    listener = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
    listener.bind(("127.0.0.1", 0))
    listener.settimeout(1.0)
    heard, done = [], threading.Event()

    def listen():
        while True:
            try:
                heard.append(listener.recv(65536))
            except TimeoutError:
                if done.is_set():
                    return

    thread = threading.Thread(target=listen)
    thread.start()
    sink = f'[{{ address = "127.0.0.1", port = {listener.getsockname()[1]}, category = 62 }}]'
    replayed(binary, flight, profile, "--udp", "--speed", "100", UTM_FUSION__OUTPUT__ASTERIX=sink, UTM_FUSION__OUTPUT__STATUS="true")
    done.set()
    thread.join()
    return heard


def wireshark(path, lines):
    """Wireshark's positions beside the lines."""
    fields = ["asterix.062_105_LAT", "asterix.062_105_LON"]
    command = ["tshark", "-r", path, "-d", "udp.port==8130,asterix", "-T", "fields", *(f"-e{field}" for field in fields)]
    printed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    columns = [[number for line in printed.splitlines() for number in line.split("\t")[at].split(",") if number] for at in (0, 1)]
    check("tshark records", len(columns[0]) == len(lines), len(columns[0]), len(lines))
    for latitude, longitude, line in zip(*columns, lines):
        track = json.loads(line)
        near("tshark latitude", float(latitude), track["lat"], 180 / 2**26 + 1e-6, track)
        near("tshark longitude", float(longitude), track["lng"], 180 / 2**26 + 1e-6, track)
        tally["positions that tshark reads"] += 1


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--binary", default=os.path.join(HERE, "../../target/release/utm-fusion"))
    options.add_argument("--tshark", action="store_true")
    options = options.parse_args()
    for flight in FLIGHTS:
        for profile in ("reference", "operational"):
            output = lambda form: replayed(options.binary, flight, profile, "-o", "-", "--output-format", form)
            octets, lines = output("cat062"), output("ndjson").decode().splitlines()
            file_of(records(octets), lines, profile)
            heard = sent(options.binary, flight, profile)
            check("datagrams", b"".join(datagram for datagram in heard if datagram[0] == 62) == octets, flight, profile)
            for category, record in (pair for datagram in heard if datagram[0] != 62 for pair in records(datagram)):
                check("010", value(record, "010", "SAC") is not None)
                if category == 63:
                    check("063 060", value(record, "060", "CON") in (0, 1, 3) and value(record, "015", raw=True) == 1)
            if options.tshark:
                with tempfile.NamedTemporaryFile(suffix=".pcap") as file:
                    file.write(output("cat062-pcap"))
                    file.flush()
                    wireshark(file.name, lines)
    for what, count in sorted(tally.items()):
        print(f"{count:9,} {what}")
    for what, *about in wrong[:10]:
        print("WRONG", what, *about)
    print(f"{len(wrong):9,} differences")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
