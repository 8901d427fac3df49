"""Cursor on Target events against PyTAK, the schema and the HTTP interface.

    python3 testdata/oracle/tak.py PROGRAM [--scenario FILE] [--schema cot_event.xsd] [--seconds 30]

runs the live service (PROGRAM run) on a simulated flight (PROGRAM simulate --udp), with two sinks: a multicast group on
loopback, and a small TAK server of this script, which asks for a client's certificate and hands on what it gets. PyTAK's own
clients receive both. Every event is held against the tracks that the HTTP interface shows of the same time, both ways
against each other, and, where it is named, against the events' schema. Inputs, group and ports are those of the scenario's
site; nothing leaves this machine.

    pip install pytak lxml; openssl has to be installed
"""

import argparse
import asyncio
import json
import pathlib
import ssl
import subprocess
import sys
import tempfile
import urllib.request
import xml.etree.ElementTree as ElementTree

import pytak
from lxml import etree

GROUP, UDP_PORT, TLS_PORT, HTTP_PORT = "239.2.3.1", 26969, 28089, 28080

parser = argparse.ArgumentParser()
parser.add_argument("program")
parser.add_argument("--scenario", default="config/scenarios/crossing.toml")
parser.add_argument("--schema")
parser.add_argument("--seconds", type=float, default=30)
arguments = parser.parse_args()


def certificates(folder):
    """An authority, a server's and a client's certificate."""

    def openssl(*words):
        subprocess.run(["openssl", *words], cwd=folder, check=True, capture_output=True)

    new = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2"]
    openssl("req", "-x509", *new, "-subj", "/CN=authority", "-keyout", "ca.key", "-out", "ca.pem")
    for name in ["server", "client", "reader"]:
        (folder / "names").write_text("subjectAltName=DNS:takserver,IP:127.0.0.1\n")
        openssl("req", "-new", *new[:-2], "-subj", f"/CN={name}", "-keyout", f"{name}.key", "-out", f"{name}.csr")
        issued = ["-CA", "ca.pem", "-CAkey", "ca.key", "-CAcreateserial", "-days", "2", "-extfile", "names"]
        openssl("x509", "-req", "-in", f"{name}.csr", *issued, "-out", f"{name}.pem")


async def server(folder):
    """Hands what each client sends to all others, as a TAK server does."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(folder / "server.pem", folder / "server.key")
    context.load_verify_locations(folder / "ca.pem")
    context.verify_mode = ssl.CERT_REQUIRED
    clients = set()

    async def serve(reader, writer):
        clients.add(writer)
        try:
            while octets := await reader.read(1 << 16):
                for other in clients - {writer}:
                    other.write(octets)
        except asyncio.CancelledError:
            pass  # the flight is over
        finally:
            clients.discard(writer)
            writer.close()

    return await asyncio.start_server(serve, "127.0.0.1", TLS_PORT, ssl=context)


async def receive(config, seen):
    """PyTAK's client and its worker: each event as it comes."""
    reader, _ = await pytak.protocol_factory(config)
    queue = asyncio.Queue()
    worker = asyncio.create_task(pytak.RXWorker(queue, config, reader).run())
    try:
        while True:
            seen.append(bytes(await queue.get()))
    finally:
        worker.cancel()


async def watch(tracks):
    """The tracks as the HTTP interface shows them, by id and time."""

    def get():
        with urllib.request.urlopen(f"http://127.0.0.1:{HTTP_PORT}/api/v1/tracks", timeout=2) as answer:
            return json.load(answer)

    while True:
        try:
            shown = await asyncio.to_thread(get)
        except OSError:
            await asyncio.sleep(0.2)
            continue
        for feature in shown["features"]:
            properties = feature["properties"]
            tracks[properties["id"], properties["time"]] = properties
        await asyncio.sleep(0.05)


async def fly(folder):
    (folder / "out").mkdir()
    simulate = [arguments.program, "simulate", arguments.scenario]
    subprocess.run([*simulate, "--out", str(folder / "out")], check=True, capture_output=True)
    site = (folder / "out" / "site.toml").read_text().replace("\ncot = []\n", "\n")
    site += f"""
[[output.cot]]
id = "group"
url = "udp://{GROUP}:{UDP_PORT}"
interface = "127.0.0.1"
[[output.cot]]
id = "server"
url = "tls://127.0.0.1:{TLS_PORT}"
ca = "ca.pem"
certificate = "client.pem"
key = "client.key"
server_name = "takserver"
"""
    (folder / "site.toml").write_text(site)
    state = {"UTM_FUSION__STATE__DIR": str(folder / "state"), "UTM_FUSION__HTTP__LISTEN": f"127.0.0.1:{HTTP_PORT}"}
    seen, tracks = {"udp": [], "tls": []}, {}
    relay = await server(folder)
    plain = {"COT_URL": f"udp+ro://{GROUP}:{UDP_PORT}", "PYTAK_MULTICAST_LOCAL_ADDR": "127.0.0.1"}
    tls = {
        "COT_URL": f"tls://127.0.0.1:{TLS_PORT}",
        "PYTAK_TLS_CLIENT_CERT": str(folder / "reader.pem"),
        "PYTAK_TLS_CLIENT_KEY": str(folder / "reader.key"),
        "PYTAK_TLS_CLIENT_CAFILE": str(folder / "ca.pem"),
    }
    tasks = [
        asyncio.create_task(receive(plain, seen["udp"])),
        asyncio.create_task(receive(tls, seen["tls"])),
        asyncio.create_task(watch(tracks)),
    ]
    await asyncio.sleep(1)
    log = open(folder / "run.log", "w")
    service = subprocess.Popen(
        [arguments.program, "run", "--config", str(folder / "site.toml")], stderr=log, env={**state}
    )
    flown = subprocess.Popen([*simulate, "--udp"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        await asyncio.sleep(arguments.seconds)
    finally:
        flown.terminate()
        service.terminate()
        service.wait(10)
    await asyncio.sleep(1)
    for task in tasks:
        if task.done() and task.exception():
            raise task.exception()
        task.cancel()
    relay.close()
    return seen, tracks


def check(seen, tracks):
    schema = etree.XMLSchema(etree.parse(arguments.schema)) if arguments.schema else None
    events = {}
    for way, texts in seen.items():
        events[way] = {}
        for text in texts:
            text = text.strip()
            if schema:
                schema.assertValid(etree.fromstring(text))
            event = ElementTree.fromstring(text)
            events[way][event.get("uid"), event.get("start")] = event
        assert len(events[way]) == len(texts), f"{way}: the same event twice"
    udp, tls = events["udp"], events["tls"]
    compared, kinds = 0, {}
    for key, event in tls.items():
        kinds[event.get("type"), event.get("how")] = kinds.get((event.get("type"), event.get("how")), 0) + 1
        if key in udp:
            assert ElementTree.tostring(event) == ElementTree.tostring(udp[key]), key
        track = tracks.get((event.get("uid").split(".", 1)[1], event.get("start")))
        if track is None:
            continue
        compared += 1
        point, motion = event.find("point"), event.find("detail/track")
        assert abs(float(point.get("lat")) - track["lat"]) < 1e-6, (track, point.attrib)
        assert abs(float(point.get("lon")) - track["lng"]) < 1e-6, (track, point.attrib)
        height = float(point.get("hae"))
        assert height == 9999999.0 if "alt" not in track else abs(height - track["alt"]) <= 0.06, (track, point.attrib)
        if motion is not None:
            assert abs(float(motion.get("speed")) - track["speed"]) < 0.011, (track, motion.attrib)
            assert abs(float(motion.get("course")) - track["track"]) % 359.9 < 0.11, (track, motion.attrib)
        else:
            assert "track" not in track, track
    both = len(udp.keys() & tls.keys())
    print(f"events      {len(udp)} over UDP, {len(tls)} over TLS, {both} of them the same octets")
    print(f"schema      {'all valid' if schema else 'not named'}")
    print(f"interface   {compared} events beside the tracks of the same time: no value differs")
    print("types       " + ", ".join(f"{kind} {how}: {count}" for (kind, how), count in sorted(kinds.items())))
    assert compared > 20 and both >= 0.95 * len(udp) > 20


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    certificates(folder)
    try:
        check(*asyncio.run(fly(folder)))
    except Exception:
        log = folder / "run.log"
        print(log.read_text()[-3000:] if log.exists() else "", file=sys.stderr)
        raise
