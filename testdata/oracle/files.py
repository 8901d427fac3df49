#!/usr/bin/env python3
"""Parquet, CSV and MCAP read by others: pyarrow, DuckDB, Polars, the mcap package.

    python3 -m venv venv && venv/bin/pip install pyarrow duckdb polars mcap pytz
    venv/bin/python testdata/oracle/files.py target/release/utm-fusion testdata/demo/capture.pcap testdata/demo/site.toml

replay: each cell of the Parquet, as each of three readers has it, against the lines of NDJSON; each message of the MCAP against
the GeoJSON. decode: each cell of each category's table against the lines of JSON.
"""

import json
import pathlib
import subprocess
import sys
import tempfile
from datetime import datetime, timezone

import duckdb
import mcap.reader
import polars
import pyarrow.parquet

PLAIN = {
    "id": "id", "source": "source", "track_number": "track_number", "state": "state", "latitude_deg": "lat",
    "longitude_deg": "lng", "height_ellipsoid_m": "alt", "altitude_msl_m": "alt_msl", "speed_m_s": "speed",
    "track_deg": "track", "vertical_speed_m_s": "vertical_speed", "accuracy_h_m": "accuracy_h_m",
    "accuracy_v_m": "accuracy_v_m", "interpolated": "interpolated", "extrapolated": "extrapolated",
    "uav_probability": "uav_probability", "integrity": "integrity", "integrity_index": "integrity_index",
    "protection_level_m": "protection_level_m", "offset_m": "offset_m",
}  # fmt: skip
TIMES = {"I015_145", "I021_071", "I021_073", "I021_075", "I021_077", "I034_030", "I048_140", "I062_070", "I063_030", "I065_030", "I129_070"}


def run(program, *arguments):
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode in (0, 4), done.stderr
    return done.stdout


def tables(path):
    """The rows of a Parquet file by each reader, without nulls."""
    bare = lambda rows: [{name: cell for name, cell in row.items() if cell is not None} for row in rows]
    yield "pyarrow", bare(pyarrow.parquet.read_table(path).to_pylist())
    duckdb.sql("SET TimeZone = 'UTC'")
    relation = duckdb.sql(f"SELECT * FROM '{path}'")
    yield "duckdb", bare([dict(zip(relation.columns, row)) for row in relation.fetchall()])
    yield "polars", bare(polars.read_parquet(path).to_dicts())


def milliseconds(cell):
    if isinstance(cell, str):
        cell = datetime.fromisoformat(cell.replace("Z", "+00:00"))
    micros = round((cell.astimezone(timezone.utc) - datetime(1970, 1, 1, tzinfo=timezone.utc)).total_seconds() * 1e6)
    return micros // 1000


def replayed(program, capture, site, folder):
    for profile in ("reference", "operational"):
        files = {kind: folder / f"{profile}.{kind}" for kind in ("parquet", "ndjson", "geojson", "mcap")}
        for file in files.values():
            run(program, "replay", capture, "--config", site, "--profile", profile, "-o", file)
        lines = [json.loads(line) for line in files["ndjson"].read_text().splitlines()]
        for reader, rows in tables(files["parquet"]):
            assert len(rows) == len(lines), (reader, len(rows), len(lines))
            cells = 0
            for row, line in zip(rows, lines):
                for column, member in PLAIN.items():
                    assert row.get(column) == line.get(member), (reader, column, row, line)
                for column in ("time", "first_seen", "last_measurement"):
                    assert (column in row) == (column in line)
                    assert column not in row or milliseconds(row[column]) == milliseconds(line[column]), (reader, column)
                assert row.get("serial_number") == line.get("uas_id", {}).get("serial_number")
                parts = {part["kind"]: part for part in line["contributors"]}
                assert row.get("radar") == parts.get("radar", {}).get("sensor")
                assert row.get("radar_track") == parts.get("radar", {}).get("track_number")
                assert row.get("distance_m") == parts.get("radar", {}).get("distance_m")
                cells += len(row)
            print(f"replay --profile {profile}: {reader}: {len(rows)} rows, {cells} cells")

        expected = {}
        for feature in json.loads(files["geojson"].read_text())["features"]:
            expected.setdefault(milliseconds(feature["properties"]["time"]), []).append(feature)
        with files["mcap"].open("rb") as stream:
            reader = mcap.reader.make_reader(stream, validate_crcs=True)
            count, tracks = 0, 0
            for schema, channel, message in reader.iter_messages():
                assert (schema.name, schema.encoding, channel.topic, channel.message_encoding) == (
                    "foxglove.GeoJSON", "jsonschema", "/tracks", "json")  # fmt: skip
                collection = json.loads(json.loads(message.data)["geojson"])
                for feature in collection["features"]:
                    assert feature["properties"].pop("name") and feature["properties"].pop("style")["color"]
                assert collection["features"] == expected.pop(message.log_time // 1_000_000, []), message.log_time
                count, tracks = count + 1, tracks + len(collection["features"])
            assert not expected and reader.get_summary().statistics.message_count == count
        print(f"replay --profile {profile}: mcap: {count} messages, {tracks} tracks, check sums right")


def flatten(row, name, value):
    """The cells of a member of a line."""
    if value is None:
        return
    if isinstance(value, dict) and set(value) != {"hex"}:
        for key, inner in value.items():
            if not key.startswith("spare") and key not in ("more", "primary", "undescribed"):
                flatten(row, f"{name}_{key}", inner)
    elif isinstance(value, (list, dict)):
        row[name] = value
    elif isinstance(value, str) and name.endswith(("_SP", "_RE")):
        row[f"{name}_hex"] = value
    else:
        row[f"{name}_s" if name in TIMES else name] = value


def decoded(program, capture, folder):
    run(program, "decode", capture, "--format", "parquet", "-o", folder)
    expected = {}
    for line in map(json.loads, run(program, "decode", capture).splitlines()):
        if "items" in line:
            row = {"offset": line["offset"], "block": line["block"]}
            for member in ("sac", "sic"):
                flatten(row, member, line.get(member))
            for item, value in line["items"].items():
                flatten(row, f"I{line['cat']:03}_{item}", value)
            if line["time"]:
                row["time"] = milliseconds(line["time"])
            expected.setdefault(line["cat"], []).append(row)
    for category, lines in sorted(expected.items()):
        for reader, rows in tables(folder / f"cat{category:03}.parquet"):
            assert len(rows) == len(lines)
            for row, line in zip(rows, lines):
                if "time" in row:
                    row["time"] = milliseconds(row["time"])
                row = {name: json.loads(cell) if isinstance(line.get(name), (list, dict)) else cell for name, cell in row.items()}
                assert row == line, (reader, row, line)
            cells = sum(map(len, rows))
            print(f"decode: CAT{category:03}: {reader}: {len(rows)} rows, {cells} cells")


def main():
    program, capture, site = sys.argv[1], sys.argv[2], sys.argv[3] if len(sys.argv) > 3 else None
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        if site:
            replayed(program, capture, site, folder)
        decoded(program, capture, folder)


if __name__ == "__main__":
    main()
