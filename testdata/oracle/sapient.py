#!/usr/bin/env python3
"""Takes SAPIENT messages of the service with protocol buffers made from the standard's own definitions, which are not part of this
project, and compares them with the picture.

    pip install grpcio-tools==1.85.1
    python3 sapient.py --proto DIR [--binary PROGRAM] [--seconds N]

DIR holds `proto_options.proto` and `bsi_flex_335_v2_0/*.proto` (github.com/dstl/Apex-SAPIENT-Middleware, sapient_msg). `simulate --udp`
flies on this machine, `run` hears it and sends to a node of this script. Each message has to have every field that the definitions call
mandatory, ids have to be UUIDs and ULIDs where they say so, and no field may be unknown to them. Each report is held against the same
track of the recording, replayed as NDJSON. Ends with 1 where anything disagrees.
"""

import argparse
import collections
import datetime
import importlib
import json
import math
import os
import re
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time

HERE = os.path.dirname(os.path.abspath(__file__))
NODE = "a8654cdf-4328-47de-81fa-c495589e30c9"
ULID = re.compile("[0-7][0-9A-HJKMNP-TV-Z]{25}")
UUID = re.compile("[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}")
tally = collections.Counter()
wrong = []


def check(what, is_right, *about):
    tally["checks"] += 1
    if not is_right:
        wrong.append((what, *about))


def compiled(proto, folder):
    """The modules of the definitions."""
    from grpc_tools import protoc

    root = os.path.join(folder, "proto", "sapient_msg")
    shutil.copytree(os.path.join(proto, "bsi_flex_335_v2_0"), os.path.join(root, "bsi_flex_335_v2_0"))
    shutil.copy(os.path.join(proto, "proto_options.proto"), root)
    files = [os.path.join(at, name) for at, _, names in os.walk(root) for name in names if name.endswith(".proto")]
    well_known = os.path.join(os.path.dirname(protoc.__file__), "_proto")
    done = protoc.main(["", f"-I{folder}/proto", f"-I{well_known}", f"--python_out={folder}", *files])
    assert done == 0, "the definitions cannot be compiled"
    sys.path.insert(0, folder)
    name = "sapient_msg.bsi_flex_335_v2_0.sapient_message_pb2"
    return importlib.import_module(name), importlib.import_module("sapient_msg.proto_options_pb2")


def valid(message, options, path=""):
    """Holds a message to the rules that the definitions state of each field."""
    from google.protobuf import unknown_fields

    check("unknown fields", len(unknown_fields.UnknownFieldSet(message)) == 0, path)
    for oneof in message.DESCRIPTOR.oneofs:
        if oneof.GetOptions().Extensions[options.oneof_options].is_mandatory:
            check("mandatory", message.WhichOneof(oneof.name) is not None, f"{path}/{oneof.name}")
    for field in message.DESCRIPTOR.fields:
        rule = field.GetOptions().Extensions[options.field_options]
        here = f"{path}/{field.name}"
        value = getattr(message, field.name)
        repeated = getattr(field, "is_repeated", None)
        repeated = field.label == field.LABEL_REPEATED if repeated is None else repeated
        is_there = len(value) > 0 if repeated else message.HasField(field.name) if field.has_presence else bool(value)
        if rule.is_mandatory:
            check("mandatory", is_there, here)
        if not is_there:
            continue
        values = value if repeated else [value]
        for each in values:
            if field.message_type is not None:
                valid(each, options, here)
            elif field.enum_type is not None:
                check("enumeration", each in field.enum_type.values_by_number and each != 0, here, each)
            elif rule.is_ulid:
                check("ULID", ULID.fullmatch(each) is not None, here, each)
            elif rule.is_uuid:
                check("UUID", UUID.fullmatch(each) is not None, here, each)


class Node:
    """Agrees to whoever registers, and keeps what is said."""

    def __init__(self, modules):
        self.message, self.options = modules
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        self.heard = []
        self.thread = threading.Thread(target=self.listen, daemon=True)
        self.thread.start()

    def listen(self):
        connection, _ = self.listener.accept()
        with connection, connection.makefile("rb") as stream:
            while header := stream.read(4):
                octets = stream.read(struct.unpack("<I", header)[0])
                message = self.message.SapientMessage()
                message.ParseFromString(octets)
                self.heard.append(message)
                check("written back", message.SerializeToString(deterministic=True) == octets)
                if message.WhichOneof("content") == "registration":
                    answer = self.message.SapientMessage(node_id="b8654cdf-4328-47de-81fa-c495589e30c9", destination_id=message.node_id)
                    answer.timestamp.GetCurrentTime()
                    answer.registration_ack.acceptance = True
                    octets = answer.SerializeToString()
                    connection.sendall(struct.pack("<I", len(octets)) + octets)


def flown(options, folder, node):
    """Flies a scenario over a site whose picture goes to the node; the tracks of the recording by id and time."""
    run = lambda *arguments, **more: subprocess.run([options.binary, *arguments], check=True, capture_output=True, **more)
    scenario = os.path.join(HERE, "../../config/scenarios/crossing.toml")
    site, recordings = os.path.join(folder, "site.toml"), os.path.join(folder, "recordings")
    run("simulate", scenario, "--out", folder)
    with open(site) as file:
        text = file.read().replace("sapient = []\n", "")
    sink = f'\n[[output.sapient]]\nid = "node"\nurl = "tcp://127.0.0.1:{node.port}"\nnode_id = "{NODE}"\n'
    with open(site, "w") as file:
        file.write(text + sink)
    environment = os.environ | {
        "UTM_FUSION__OUTPUT__RECORD": f'{{ dir = "{recordings}" }}', "UTM_FUSION__STATE__DIR": os.path.join(folder, "state"),
        "UTM_FUSION__HTTP__LISTEN": "127.0.0.1:0"}
    with open(os.path.join(folder, "log"), "wb") as log:
        service = subprocess.Popen([options.binary, "run", "--config", site], env=environment, stdout=log, stderr=log)
        time.sleep(2)
        flight = subprocess.Popen([options.binary, "simulate", scenario, "--udp"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(options.seconds)
        flight.kill()
        flight.wait()
        service.send_signal(signal.SIGINT)
        service.wait(30)
    node.thread.join(10)
    (capture,) = (os.path.join(recordings, name) for name in os.listdir(recordings) if re.fullmatch(r"input-.*\.pcap", name))
    name = capture.removesuffix(".pcap")
    lines = run("replay", capture, "--config", f"{name}.site.toml", "--state", name, "-o", "-", "--output-format", "ndjson").stdout
    tracks = map(json.loads, lines.splitlines())
    return {(track["id"], milliseconds(track["time"])): track for track in tracks}


def milliseconds(text):
    return round(datetime.datetime.fromisoformat(text.replace("Z", "+00:00")).timestamp() * 1000)


def near(what, has, said, known, within, about):
    """A track has a value where the report has one, and it is that one."""
    check(what, has == (known is not None) and (not has or abs(said - known) <= within), said, known, about)


def compare(report, track):
    place, degree = report.location, 111_195.0
    near("longitude", True, place.x, track["lng"], 1e-8, track)
    near("latitude", True, place.y, track["lat"], 1e-8, track)
    near("height", place.HasField("z"), place.z, track.get("alt"), 0.002, track)
    check("units", (place.coordinate_system, place.datum) == (1, 1))
    # The radius of 95 % lies between those of a line along the longer axis and of a circle.
    east, north = place.x_error * degree * math.cos(math.radians(place.y)), place.y_error * degree
    check("errors", track["accuracy_h_m"] <= 2.4478 * math.hypot(east, north) + 0.01, east, north, track)
    check("errors", track["accuracy_h_m"] >= 1.9599 * max(east, north) - 0.01, east, north, track)
    near("height error", place.HasField("z_error"), 1.96 * place.z_error, track.get("accuracy_v_m"), 0.01, track)
    velocity = report.enu_velocity
    near("speed", True, math.hypot(velocity.east_rate, velocity.north_rate), track["speed"], 0.006, track)
    near("climb", velocity.HasField("up_rate"), velocity.up_rate, track.get("vertical_speed"), 0.006, track)
    serial = track.get("uas_id", {}).get("serial_number")
    check("id", (report.id or None) == serial, report.id, serial)
    info = {entry.type: entry.value for entry in report.track_info}
    check("source", info["source"] == track["source"], info, track)
    check("extrapolated", (info.get("extrapolated") == "true") == track["extrapolated"], info, track)
    check("integrity", info.get("integrity") == track.get("integrity"), info, track)


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--proto", required=True)
    options.add_argument("--binary", default=os.path.join(HERE, "../../target/release/utm-fusion"))
    options.add_argument("--seconds", type=int, default=60)
    options = options.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        modules = compiled(options.proto, os.path.join(folder, "compiled"))
        node = Node(modules)
        tracks = flown(options, os.path.join(folder, "flight"), node)
    objects = collections.defaultdict(set)
    seen = set()
    for number, message in enumerate(node.heard):
        content = message.WhichOneof("content")
        tally[content] += 1
        valid(message, modules[1])
        check("order", (content == "registration") == (number == 0), number, content)
        if content != "detection_report":
            continue
        report = message.detection_report
        name = next(entry.value for entry in report.track_info if entry.type == "id")
        objects[name].add(report.object_id)
        if report.state == "lost":
            tally["lost"] += 1
            continue
        # A slot is published 6.25 s after it opens, and its centre is 0.125 s after that.
        at = (name, message.timestamp.ToMilliseconds() - 6125)
        check("once", at not in seen, at)
        seen.add(at)
        check("track", at in tracks, at)
        if at in tracks:
            compare(report, tracks[at])
    check("one object a track", all(len(those) == 1 for those in objects.values()))
    check("one track an object", len(set.union(set(), *objects.values())) == len(objects))
    seconds = {time for _, time in seen}
    check("every track of every second", seen == {at for at in tracks if at[1] in seconds}, len(seen))
    last = node.heard[-1]
    check("goodbye", last.WhichOneof("content") == "status_report" and last.status_report.system == 5)
    for what, count in sorted(tally.items()):
        print(f"{count:9,} {what}")
    print(f"{len(objects):9,} objects, {len(seconds)} seconds")
    for what, *about in wrong[:10]:
        print("WRONG", what, *about)
    print(f"{len(wrong):9,} differences")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
