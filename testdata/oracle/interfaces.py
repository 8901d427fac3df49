"""The HTTP interface against others' readers of the same formats.

    python3 testdata/oracle/interfaces.py http://127.0.0.1:8080 [remoteid.yaml]

asks a running service (`replay --serve`, `demo --http`, `run`; some tracks should be fused) and has its answers checked:
OpenAPI by openapi-spec-validator, the tracks by jsonschema with the document's own schema, metrics by prometheus_client,
GeoJSON by geojson, geojson-pydantic and shapely, and F3411-22a by the schemas of its API where that file is named
(remoteid/updated.yaml of github.com/uastech/standards).
Random requests, the stream's among them, are made by schemathesis from the OpenAPI document: none may be answered 5xx.

    pip install openapi-spec-validator prometheus_client geojson geojson-pydantic shapely jsonschema pyyaml schemathesis
"""

import json
import sys
import time
import urllib.request

import geojson
import hypothesis
import jsonschema
import requests
import schemathesis
import shapely.geometry
import yaml
from geojson_pydantic import FeatureCollection
from openapi_spec_validator import validate
from prometheus_client.parser import text_string_to_metric_families
from schemathesis.specs.openapi import checks

service = sys.argv[1].rstrip("/")


def get(path):
    with urllib.request.urlopen(service + path, timeout=10) as answer:
        return answer.read().decode()


def check_geojson():
    get("/api/v1/raw")  # which is kept from the first request on
    time.sleep(2)
    for path in ["tracks", "tracks?trail_s=60", "sensors", "coverage", "areas", "raw"]:
        text = get(f"/api/v1/{path}")
        collection = geojson.loads(text)
        assert collection.is_valid, collection.errors()
        FeatureCollection.model_validate_json(text)
        for feature in collection["features"]:
            assert feature["geometry"] is None or shapely.geometry.shape(feature["geometry"]).is_valid, feature
        print(f"geojson     {path}: {len(collection['features'])} features")


def check_tracks(document):
    schema = {"$ref": "#/components/schemas/Tracks", "components": document["components"]}
    validator = jsonschema.Draft202012Validator(schema, format_checker=jsonschema.FormatChecker())
    for query in ["", "?trail_s=60"]:
        tracks = json.loads(get(f"/api/v1/tracks{query}"))
        validator.validate(tracks)
    estimated = sum("speed" in track["properties"] for track in tracks["features"])
    print(f"tracks      {len(tracks['features'])} as the document describes them, {estimated} with an estimate")


def check_metrics():
    families = list(text_string_to_metric_families(get("/metrics")))
    names = [family.name for family in families]
    assert len(set(names)) == len(names) and all(family.documentation for family in families)
    print(f"metrics     {len(families)} families, {sum(len(family.samples) for family in families)} samples")


def check_remote_id(file):
    components = yaml.safe_load(open(file))["components"]

    def check(name, answer):
        schema = {"$ref": f"#/components/schemas/{name}", "components": components}
        # OpenAPI 3.0 has the keywords of JSON Schema's draft 4.
        jsonschema.Draft4Validator(schema, format_checker=jsonschema.FormatChecker()).validate(answer)

    tracks = json.loads(get("/api/v1/tracks"))["features"]
    known = [track["properties"] for track in tracks if "uas_id" in track["properties"]]
    count = 0
    for track in known:
        lat, lng = track["lat"], track["lng"]
        view = f"{lat - 0.01},{lng - 0.01},{lat + 0.01},{lng + 0.01}"
        for recent in ["", "&recent_positions_duration=60"]:
            flights = json.loads(get(f"/uss/flights?view={view}{recent}"))
            check("GetFlightsResponse", flights)
        for flight in flights["flights"]:
            check("GetFlightDetailsResponse", json.loads(get(f"/uss/flights/{flight['id']}/details")))
            count += 1
    assert count, "no flight: the service should show some fused tracks"
    print(f"remote id   {count} flights around {len(known)} tracks")


def check_random_requests():
    schema = schemathesis.openapi.from_url(f"{service}/openapi.json")
    statuses = {}
    settings = hypothesis.settings(
        max_examples=60, deadline=None, suppress_health_check=list(hypothesis.HealthCheck), derandomize=True
    )
    for operation in schema.get_all_operations():
        operation = operation.ok()

        @hypothesis.given(case=operation.as_strategy())
        @settings
        def ask(case):
            arguments = case.as_transport_kwargs(base_url=service)
            with requests.request(**{**arguments, "stream": True, "timeout": 10}) as answer:
                assert answer.status_code < 500 or answer.status_code == 503, answer.text
                if answer.headers["content-type"].startswith("text/event-stream"):
                    next(answer.iter_content(65536))  # a stream does not end: its beginning is enough
                    statuses["streams"] = statuses.get("streams", 0) + 1
                else:
                    response = schemathesis.Response.from_requests(answer, verify=True)
                    # Nor does a random text that the document allows have to make sense to the service.
                    case.validate_response(response, excluded_checks=[checks.positive_data_acceptance])
                statuses[answer.status_code] = statuses.get(answer.status_code, 0) + 1

        ask()
    print(f"random      answers by status {statuses}")


document = json.loads(get("/openapi.json"))
validate(document)
print(f"openapi     {len(document['paths'])} paths")
check_tracks(document)
check_geojson()
check_metrics()
if len(sys.argv) > 2:
    check_remote_id(sys.argv[2])
check_random_requests()
