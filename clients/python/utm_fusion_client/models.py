"""Made of /openapi.json and /api/v1/asyncapi.json by tests/readers/generate.rs; UPDATE=1 makes it anew."""

from typing import Any, Literal, NotRequired, TypedDict, Union

About = TypedDict(
    "About",
    {
        "min_zoom": int,
        "max_zoom": int,
        "attribution": str,
    },
)

Aircraft = TypedDict(
    "Aircraft",
    {
        "hex": str,
        "type": Literal["adsb_icao", "tisb_trackfile", "other"],
        "lat": float,
        "lon": float,
        "seen": float,
        "seen_pos": float,
        "mlat": list[Any],
        "tisb": list[Any],
        "category": NotRequired[Literal["A1", "A2", "A3", "A4", "A5", "A6", "A7", "B1", "B2", "B3", "B4", "B6", "B7", "C1", "C2", "C3", "C4", "C5"]],
        "t": NotRequired[Literal["UHEL"]],
        "desc": NotRequired[Literal["Drone"]],
        "flight": str,
        "alt_geom": NotRequired[int],
        "gs": NotRequired[float],
        "nac_p": NotRequired[int],
        "nac_v": NotRequired[int],
        "track": NotRequired[float],
        "geom_rate": NotRequired[int],
        "gva": NotRequired[int],
    },
)

AircraftJson = TypedDict(
    "AircraftJson",
    {
        "icao24": str,
        "callsign": NotRequired[str],
        "emitter_category": NotRequired[int],
    },
)

AlertClosest = TypedDict(
    "AlertClosest",
    {
        "at": str,
        "horizontal_m": float,
        "vertical_m": NotRequired[float],
    },
)

AlertArea = TypedDict(
    "AlertArea",
    {
        "name": str,
        "identifier": NotRequired[str],
        "type": NotRequired[Literal["prohibited", "authorisation", "conditional", "u-space", "no-restriction"]],
    },
)

AlertAcknowledged = TypedDict(
    "AlertAcknowledged",
    {
        "by": str,
        "at": str,
        "note": NotRequired[str],
    },
)

AlertShelved = TypedDict(
    "AlertShelved",
    {
        "by": str,
        "at": str,
        "until": str,
        "note": NotRequired[str],
    },
)

Alert = TypedDict(
    "Alert",
    {
        "id": str,
        "kind": Literal["sensor", "area", "area-predicted", "service", "registration", "integrity", "jamming", "silent", "height", "uncooperative", "conflict", "emergency"],
        "severity": Literal["warning", "critical"],
        "since": str,
        "worst": NotRequired[Literal["warning", "critical"]],
        "text": str,
        "sensor": NotRequired[str],
        "track": NotRequired[str],
        "conflict": NotRequired[str],
        "part": NotRequired[str],
        "identity": NotRequired[str],
        "track_id": NotRequired[str],
        "twin_id": NotRequired[str],
        "state": NotRequired[Literal["unverified", "verified", "suspect", "failed"]],
        "reasons": NotRequired[list[Literal["radar", "jump", "frozen", "replay", "duplicate", "swapped", "velocity", "time"]]],
        "offset_m": NotRequired[float],
        "height_offset_m": NotRequired[float],
        "tracks": NotRequired[list[str]],
        "volume": NotRequired[str],
        "closest": NotRequired["AlertClosest"],
        "entered": NotRequired[bool],
        "identities": NotRequired[list[str]],
        "hull": NotRequired["Hull"],
        "resolved": NotRequired[bool],
        "area": NotRequired["AlertArea"],
        "height_unknown": NotRequired[bool],
        "time_to_entry_s": NotRequired[float],
        "earliest_s": NotRequired[float],
        "acknowledged": NotRequired["AlertAcknowledged"],
        "shelved": NotRequired["AlertShelved"],
        "until": NotRequired[str],
        "latched": NotRequired[bool],
    },
)

AlertShelf = TypedDict(
    "AlertShelf",
    {
        "minutes": float,
        "by": NotRequired[Union[str, None]],
        "note": NotRequired[Union[str, None]],
    },
)

AlertWord = TypedDict(
    "AlertWord",
    {
        "by": NotRequired[Union[str, None]],
        "note": NotRequired[Union[str, None]],
    },
)

Alerts = TypedDict(
    "Alerts",
    {
        "time": str,
        "alerts": list["Alert"],
        "latched": list["Alert"],
        "ended": list["Alert"],
        "more": NotRequired[bool],
    },
)

Also = TypedDict(
    "Also",
    {
        "uas_id": NotRequired["UasId"],
        "aircraft": NotRequired["AircraftJson"],
        "sensor": str,
        "track_number": int,
        "time": NotRequired[str],
    },
)

Altitude = TypedDict(
    "Altitude",
    {
        "value": float,
        "reference": Literal["W84"],
        "units": Literal["M"],
    },
)

AreaProperties = TypedDict(
    "AreaProperties",
    {
        "kind": Literal["mask", "coverage", "alert"],
        "name": str,
        "sensor": NotRequired[str],
        "identifier": NotRequired[str],
        "type": NotRequired[Literal["prohibited", "authorisation", "conditional", "u-space", "no-restriction"]],
        "conditions": NotRequired[str],
        "floor_m": NotRequired[float],
        "ceiling_m": NotRequired[float],
        "active": bool,
        "changes_at": NotRequired[str],
        "hours": str,
        "severity": NotRequired[Literal["warning", "critical"]],
        "activated_by": NotRequired[str],
        "format": Literal["geojson", "ed-318", "ed-269"],
    },
)

CameraCues = TypedDict(
    "CameraCues",
    {
        "sensor": str,
        "oriented": bool,
        "targets": list["Cue"],
    },
)

CameraOrientation = TypedDict(
    "CameraOrientation",
    {
        "bearing_deg": "RegistrationValue",
        "tilt_east_deg": "RegistrationValue",
        "tilt_north_deg": "RegistrationValue",
        "looks": int,
        "residual_deg": NotRequired[float],
        "turned": NotRequired[str],
    },
)

CellState = TypedDict(
    "CellState",
    {
        "cell": str,
        "owner": NotRequired[str],
        "standby": NotRequired[str],
        "lease": int,
        "behind": int,
        "step": int,
        "left_out": str,
        "is_missing": bool,
        "is_foreign": bool,
        "corners": list[list[float]],
    },
)

ClockDifference = TypedDict(
    "ClockDifference",
    {
        "gateway": str,
        "other": str,
        "difference_s": float,
        "datagrams": int,
        "apart": bool,
    },
)

ClockSource = Union[Literal["chrony"], Literal["kernel"], Literal["systemd"]]

ClockStanding = Union[Literal["good"], Literal["warning"], Literal["degraded"], Literal["unbounded"], Literal["unsynchronised"], Literal["unknown"]]

Closed = TypedDict(
    "Closed",
    {
        "reason": str,
    },
)

Collection = TypedDict(
    "Collection",
    {
        "id": Literal["tracks", "areas"],
        "title": str,
        "description": str,
        "extent": "Extent",
        "itemType": Literal["feature"],
        "crs": list[str],
        "links": list["Link2"],
    },
)

CollectionOfFeatureOfAreaProperties = TypedDict(
    "CollectionOfFeatureOfAreaProperties",
    {
        "type": Union[Literal["FeatureCollection"]],
        "features": list["FeatureOfAreaProperties"],
    },
)

CollectionOfFeatureOfCoverageProperties = TypedDict(
    "CollectionOfFeatureOfCoverageProperties",
    {
        "type": Union[Literal["FeatureCollection"]],
        "features": list["FeatureOfCoverageProperties"],
    },
)

CollectionOfFeatureOfZoneLimits = TypedDict(
    "CollectionOfFeatureOfZoneLimits",
    {
        "type": Union[Literal["FeatureCollection"]],
        "features": list["FeatureOfZoneLimits"],
    },
)

Collections = TypedDict(
    "Collections",
    {
        "links": list["Link2"],
        "collections": list["Collection"],
    },
)

Competitor = TypedDict(
    "Competitor",
    {
        "sensor": str,
        "track_number": NotRequired[int],
        "uas_id": NotRequired["TransponderId"],
        "log_likelihood_ratio": float,
        "decorrelated": NotRequired[bool],
    },
)

Conflict = TypedDict(
    "Conflict",
    {
        "id": NotRequired[str],
        "time": str,
        "seen": NotRequired[str],
        "a": str,
        "b": str,
        "volume": str,
        "level": Literal["none", "advisory", "warning", "violation"],
        "since": NotRequired[str],
        "t_cpa_s": float,
        "d_cpa_h_m": float,
        "d_cpa_v_m": NotRequired[float],
        "d_now_h_m": float,
        "d_now_v_m": NotRequired[float],
        "t_entry_s": float,
        "t_exit_s": NotRequired[float],
        "probability": float,
        "vertical_known": bool,
        "vertical_coarse": NotRequired[bool],
        "entered": NotRequired[bool],
        "miss": "MissJson",
        "cpa": "CpaJson",
        "integrity": NotRequired[Literal["unverified", "verified", "suspect", "failed"]],
    },
)

Conflicts = TypedDict(
    "Conflicts",
    {
        "time": str,
        "computed": bool,
        "reason": NotRequired[str],
        "volumes": list["Volume"],
        "aircraft": int,
        "left_out": int,
        "conflicts": list["Conflict"],
    },
)

ConformanceClasses = TypedDict(
    "ConformanceClasses",
    {
        "conformsTo": list[str],
    },
)

Contested = TypedDict(
    "Contested",
    {
        "counts": str,
        "refused": str,
        "reason": Literal["other_sender", "foreign_source"],
        "transponders": list[str],
    },
)

Contributor = TypedDict(
    "Contributor",
    {
        "kind": Literal["radar", "transponder", "camera"],
        "sensor": str,
        "track_number": int,
        "time": NotRequired[str],
        "weight": NotRequired[float],
        "height_measured": NotRequired[bool],
        "distance_m": NotRequired[float],
        "threshold_m": NotRequired[float],
        "ratio": NotRequired[float],
        "within": NotRequired[int],
        "co_present": NotRequired[int],
        "manual": NotRequired[bool],
        "log_likelihood_ratio": NotRequired[float],
        "threshold": NotRequired["Threshold"],
        "competitors": NotRequired[list["Competitor"]],
    },
)

Correlation = TypedDict(
    "Correlation",
    {
        "sensor": str,
        "track_number": int,
        "uas_id": "TransponderId",
        "verdict": Literal["correlated", "decorrelated"],
        "since": str,
    },
)

Correlations = TypedDict(
    "Correlations",
    {
        "correlations": list["Correlation"],
    },
)

CoverageProperties = TypedDict(
    "CoverageProperties",
    {
        "sensor": str,
        "kind": Literal["radar", "transponder", "adsb", "remote-id", "camera"],
        "shape": Literal["area", "circle"],
        "max_range_m": NotRequired[float],
    },
)

CpaJson = TypedDict(
    "CpaJson",
    {
        "a": list[float],
        "b": list[float],
    },
)

Cue = TypedDict(
    "Cue",
    {
        "track": str,
        "name": str,
        "reason": Literal["violation", "warning", "uncooperative", "untrusted", "unidentified"],
        "azimuth_deg": float,
        "elevation_deg": NotRequired[float],
        "azimuth_deviation_deg": NotRequired[float],
        "elevation_deviation_deg": NotRequired[float],
        "stated_azimuth_deg": float,
        "stated_elevation_deg": NotRequired[float],
        "distance_m": float,
    },
)

Cueing = TypedDict(
    "Cueing",
    {
        "time": str,
        "cameras": list["CameraCues"],
    },
)

Ellipse = TypedDict(
    "Ellipse",
    {
        "major_m": float,
        "minor_m": float,
        "azimuth_deg": float,
    },
)

Ended = TypedDict(
    "Ended",
    {
        "time": str,
        "ids": list[str],
    },
)

Extent = TypedDict(
    "Extent",
    {
        "spatial": "SpatialExtent",
    },
)

Fault = TypedDict(
    "Fault",
    {
        "category": Union[int, None],
        "reason": str,
        "count": int,
    },
)

FeatureOfAreaProperties = TypedDict(
    "FeatureOfAreaProperties",
    {
        "type": Literal["Feature"],
        "geometry": "Geometry",
        "properties": "AreaProperties",
    },
)

FeatureOfCoverageProperties = TypedDict(
    "FeatureOfCoverageProperties",
    {
        "type": Literal["Feature"],
        "id": str,
        "geometry": Union["Geometry", None],
        "properties": "CoverageProperties",
    },
)

FeatureOfPastPropertiesGeometry = TypedDict(
    "FeatureOfPastPropertiesGeometry",
    {
        "type": Literal["Point"],
        "coordinates": "Position",
    },
)

FeatureOfPastProperties = TypedDict(
    "FeatureOfPastProperties",
    {
        "type": Literal["Feature"],
        "id": str,
        "geometry": "FeatureOfPastPropertiesGeometry",
        "properties": "PastProperties",
    },
)

FeatureOfReportPropertiesGeometry = TypedDict(
    "FeatureOfReportPropertiesGeometry",
    {
        "type": Literal["Point"],
        "coordinates": "Position",
    },
)

FeatureOfReportProperties = TypedDict(
    "FeatureOfReportProperties",
    {
        "type": Literal["Feature"],
        "geometry": "FeatureOfReportPropertiesGeometry",
        "properties": "ReportProperties",
    },
)

FeatureOfSensorPropertiesGeometry = TypedDict(
    "FeatureOfSensorPropertiesGeometry",
    {
        "type": Literal["Point"],
        "coordinates": "Position",
    },
)

FeatureOfSensorProperties = TypedDict(
    "FeatureOfSensorProperties",
    {
        "type": Literal["Feature"],
        "id": str,
        "geometry": "FeatureOfSensorPropertiesGeometry",
        "properties": "SensorProperties",
    },
)

FeatureOfTrackPropertiesGeometry = TypedDict(
    "FeatureOfTrackPropertiesGeometry",
    {
        "type": Literal["Point"],
        "coordinates": "Position",
    },
)

FeatureOfTrackProperties = TypedDict(
    "FeatureOfTrackProperties",
    {
        "type": Literal["Feature"],
        "id": str,
        "geometry": "FeatureOfTrackPropertiesGeometry",
        "properties": "TrackProperties",
    },
)

FeatureOfTrailProperties = TypedDict(
    "FeatureOfTrailProperties",
    {
        "type": Literal["Feature"],
        "id": str,
        "geometry": "Geometry",
        "properties": "TrailProperties",
    },
)

FeatureOfZoneLimits = TypedDict(
    "FeatureOfZoneLimits",
    {
        "type": Literal["Feature"],
        "geometry": "Geometry",
        "properties": "ZoneLimits",
    },
)

FlightDetails = TypedDict(
    "FlightDetails",
    {
        "details": "RIDFlightDetails",
    },
)

Flights = TypedDict(
    "Flights",
    {
        "timestamp": "RIDTime",
        "flights": list["RIDFlight"],
    },
)

GatewayState = TypedDict(
    "GatewayState",
    {
        "node": str,
        "lines": int,
        "written": int,
        "waiting": int,
        "dropped": int,
        "clock": "ClockStanding",
        "clock_bound_s": NotRequired[float],
        "clock_by": NotRequired["ClockSource"],
        "unfit": bool,
        "silent": bool,
        "withheld": int,
        "clock_ahead_s": NotRequired[float],
    },
)

Geometry1 = TypedDict(
    "Geometry1",
    {
        "type": Literal["Point"],
        "coordinates": "Position",
    },
)

Geometry2 = TypedDict(
    "Geometry2",
    {
        "type": Literal["LineString"],
        "coordinates": list["Position"],
    },
)

Geometry3 = TypedDict(
    "Geometry3",
    {
        "type": Literal["MultiLineString"],
        "coordinates": list[list["Position"]],
    },
)

Geometry4 = TypedDict(
    "Geometry4",
    {
        "type": Literal["Polygon"],
        "coordinates": list[list["Position"]],
    },
)

Geometry5 = TypedDict(
    "Geometry5",
    {
        "type": Literal["MultiPolygon"],
        "coordinates": list[list[list["Position"]]],
    },
)

Geometry = Union["Geometry1", "Geometry2", "Geometry3", "Geometry4", "Geometry5"]

Health = TypedDict(
    "Health",
    {
        "status": Literal["ok", "ready"],
    },
)

Heartbeat = TypedDict(
    "Heartbeat",
    {
        "time": NotRequired[str],
        "seq": int,
        "latency_s": NotRequired[float],
        "late_s": NotRequired[float],
    },
)

Hull = TypedDict(
    "Hull",
    {
        "type": Literal["Polygon"],
        "coordinates": list[list[list[float]]],
    },
)

IdentityIntegrity = TypedDict(
    "IdentityIntegrity",
    {
        "identity": str,
        "uas_id": "TransponderId",
        "track_id": NotRequired[str],
        "state": Literal["unverified", "verified", "suspect", "failed"],
        "since": str,
        "index": float,
        "protection_level_m": NotRequired[float],
        "offset": NotRequired["IntegrityOffset"],
        "reasons": list[Literal["radar", "jump", "frozen", "replay", "duplicate", "swapped", "velocity", "time"]],
        "heard": str,
        "silent": bool,
        "verdict": NotRequired[Literal["trusted", "distrusted"]],
        "verdict_since": NotRequired[str],
        "twin_id": NotRequired[str],
        "evidence": list["IntegrityEvidence"],
    },
)

Info = TypedDict(
    "Info",
    {
        "name": Literal["utm-fusion"],
        "version": str,
        "site": "Site",
        "geoid_separation": float,
        "profile": Literal["operational", "reference"],
        "slot_s": float,
        "latency_s": float,
        "now": bool,
        "cluster": bool,
        "started": str,
        "mode": Literal["live", "replay"],
        "auth": Literal["none", "tokens"],
        "control": bool,
        "settings": "Settings",
        "tiles": NotRequired["Tiles"],
        "basemap": NotRequired["About"],
        "history_hours": NotRequired[float],
        "replay": NotRequired["Replay"],
    },
)

Integrity = TypedDict(
    "Integrity",
    {
        "time": NotRequired[str],
        "computed": bool,
        "identities": list["IdentityIntegrity"],
    },
)

IntegrityEvidence = TypedDict(
    "IntegrityEvidence",
    {
        "sensor": str,
        "track_number": int,
        "kind": Literal["near", "far"],
        "from": str,
        "seconds": int,
        "gain": float,
    },
)

IntegrityOffset = TypedDict(
    "IntegrityOffset",
    {
        "east_m": float,
        "north_m": float,
        "covariance_m2": list[list[float]],
    },
)

IntegrityVerdict = TypedDict(
    "IntegrityVerdict",
    {
        "verdict": Literal["trusted", "distrusted", "automatic"],
    },
)

ItemsOfFeatureOfAreaProperties = TypedDict(
    "ItemsOfFeatureOfAreaProperties",
    {
        "type": Union[Literal["FeatureCollection"]],
        "timeStamp": str,
        "numberMatched": int,
        "numberReturned": int,
        "links": list["Link2"],
        "features": list["FeatureOfAreaProperties"],
    },
)

ItemsOfFeatureOfTrackProperties = TypedDict(
    "ItemsOfFeatureOfTrackProperties",
    {
        "type": Union[Literal["FeatureCollection"]],
        "timeStamp": str,
        "numberMatched": int,
        "numberReturned": int,
        "links": list["Link2"],
        "features": list["FeatureOfTrackProperties"],
    },
)

LandingPage = TypedDict(
    "LandingPage",
    {
        "title": str,
        "description": str,
        "links": list["Link2"],
    },
)

LatLngPoint = TypedDict(
    "LatLngPoint",
    {
        "lat": float,
        "lng": float,
    },
)

Learnt = TypedDict(
    "Learnt",
    {
        "summary": str,
        "range_m": "LearntErrors",
        "azimuth_deg": "LearntErrors",
        "height_m": "LearntErrors",
        "velocity": "LearntVelocity",
    },
)

LearntDelay = TypedDict(
    "LearntDelay",
    {
        "value": float,
        "deviation": float,
        "applied": float,
    },
)

LearntErrors = TypedDict(
    "LearntErrors",
    {
        "of_data_sheet": "LearntNumber",
        "bias": "LearntNumber",
        "correlation_s": "LearntNumber",
        "turn_factor": "LearntNumber",
        "noise": "LearntNumber",
        "samples": float,
    },
)

LearntNumber = TypedDict(
    "LearntNumber",
    {
        "value": float,
        "deviation": float,
    },
)

LearntTransponderType = TypedDict(
    "LearntTransponderType",
    {
        "manufacturer": NotRequired[str],
        "model": NotRequired[str],
        "summary": str,
        "reports": int,
        "horizontal_m": "LearntNumber",
        "vertical_m": "LearntNumber",
        "delay_s": "LearntDelay",
    },
)

LearntVelocity = TypedDict(
    "LearntVelocity",
    {
        "verdict": Literal["unknown", "used", "ignored"],
        "error_m_s": NotRequired["LearntNumber"],
    },
)

Line = TypedDict(
    "Line",
    {
        "name": str,
        "joined": bool,
        "received": int,
        "duplicates": int,
        "foreign": int,
        "queue_full": int,
        "kernel_dropped": int,
        "last_received": NotRequired[str],
        "untranslated": NotRequired[dict[str, int]],
    },
)

Link = TypedDict(
    "Link",
    {
        "id": str,
        "relation": Literal["disputed"],
    },
)

Link2 = TypedDict(
    "Link2",
    {
        "href": str,
        "rel": Literal["self", "service-desc", "service-doc", "conformance", "data", "items", "collection", "next"],
        "type": Literal["application/json", "application/geo+json", "text/html", "application/vnd.oai.openapi+json;version=3.1"],
    },
)

Members = TypedDict(
    "Members",
    {
        "region": str,
        "cells": list["CellState"],
        "nodes": list["NodeState"],
        "gateways": list["GatewayState"],
        "clocks": list["ClockDifference"],
        "missing_gateways": list[str],
        "different": list[str],
        "shown": int,
        "doubled": int,
        "missing": int,
        "twice": int,
        "too_late": int,
    },
)

MissJson = TypedDict(
    "MissJson",
    {
        "across_m": float,
        "vertical_m": NotRequired[float],
        "covariance_m2": list[list[float]],
    },
)

NodeState = TypedDict(
    "NodeState",
    {
        "node": str,
        "machine": str,
        "part": Literal["owner", "standby", "none", "drained"],
        "owns": list[str],
        "stands_by": list[str],
        "takeovers": int,
        "fenced": int,
        "diverged": int,
        "published": int,
        "checkpoints": int,
        "clock_ahead_s": NotRequired[float],
    },
)

OperatorLocation = TypedDict(
    "OperatorLocation",
    {
        "position": "LatLngPoint",
        "altitude": NotRequired["Altitude"],
        "altitude_type": Literal["Takeoff", "Dynamic", "Fixed"],
    },
)

OperatorPlace = TypedDict(
    "OperatorPlace",
    {
        "lat": float,
        "lng": float,
        "alt": NotRequired[float],
        "type": Literal["Takeoff", "Dynamic", "Fixed"],
    },
)

PastPosition = TypedDict(
    "PastPosition",
    {
        "lat": float,
        "lng": float,
        "alt": float,
    },
)

PastProperties = TypedDict(
    "PastProperties",
    {
        "id": str,
        "source": Literal["fused", "radar", "transponder", "camera"],
        "track_number": int,
        "time": str,
        "lat": float,
        "lng": float,
        "alt_msl": NotRequired[float],
    },
)

Picture = TypedDict(
    "Picture",
    {
        "now": float,
        "messages": int,
        "aircraft": list["Aircraft"],
    },
)

Position = list[float]

Problem = TypedDict(
    "Problem",
    {
        "type": Literal["about:blank"],
        "title": str,
        "status": int,
        "detail": str,
        "parameter": NotRequired[str],
        "reasons": NotRequired[list[str]],
        "retry_after_s": NotRequired[int],
    },
)

Quantiles = TypedDict(
    "Quantiles",
    {
        "p50": float,
        "p95": float,
        "p99": float,
    },
)

RIDAircraftPosition = TypedDict(
    "RIDAircraftPosition",
    {
        "lat": float,
        "lng": float,
        "alt": float,
        "accuracy_h": Literal["HA1m", "HA3m", "HA10m", "HA30m", "HA005NM", "HA01NM", "HA03NM", "HA05NM", "HA1NM", "HA2NM", "HA4NM", "HA10NM", "HA10NMPlus", "HAUnknown"],
        "accuracy_v": Literal["VA1m", "VA3m", "VA10m", "VA25m", "VA45m", "VA150m", "VA150mPlus", "VAUnknown"],
        "extrapolated": bool,
    },
)

RIDAircraftState = TypedDict(
    "RIDAircraftState",
    {
        "timestamp": "RIDTime",
        "timestamp_accuracy": float,
        "operational_status": Literal["Undeclared", "Ground", "Airborne", "Emergency", "RemoteIDSystemFailure"],
        "position": "RIDAircraftPosition",
        "track": float,
        "speed": float,
        "speed_accuracy": Literal["SA03mps", "SA1mps", "SA3mps", "SA10mps", "SA10mpsPlus", "SAUnknown"],
        "vertical_speed": float,
        "height": NotRequired["RIDHeight"],
    },
)

RIDFlight = TypedDict(
    "RIDFlight",
    {
        "id": str,
        "aircraft_type": Literal["NotDeclared", "Aeroplane", "Helicopter", "Gyroplane", "HybridLift", "Ornithopter", "Glider", "Kite", "FreeBalloon", "CaptiveBalloon", "Airship", "FreeFallOrParachute", "Rocket", "TetheredPoweredAircraft", "GroundObstacle", "Other"],
        "simulated": bool,
        "current_state": "RIDAircraftState",
        "recent_positions": NotRequired[list["RIDRecentAircraftPosition"]],
    },
)

RIDFlightDetailsUasId1 = TypedDict(
    "RIDFlightDetailsUasId1",
    {
        "serial_number": str,
    },
)

RIDFlightDetailsUasId2 = TypedDict(
    "RIDFlightDetailsUasId2",
    {
        "registration_id": str,
    },
)

RIDFlightDetailsUasId3 = TypedDict(
    "RIDFlightDetailsUasId3",
    {
        "utm_id": str,
    },
)

RIDFlightDetailsUasId4 = TypedDict(
    "RIDFlightDetailsUasId4",
    {
        "specific_session_id": str,
    },
)

RIDFlightDetails = TypedDict(
    "RIDFlightDetails",
    {
        "id": str,
        "uas_id": Union["RIDFlightDetailsUasId1", "RIDFlightDetailsUasId2", "RIDFlightDetailsUasId3", "RIDFlightDetailsUasId4"],
        "operator_id": NotRequired[str],
        "operator_location": NotRequired["OperatorLocation"],
    },
)

RIDHeight = TypedDict(
    "RIDHeight",
    {
        "distance": float,
        "reference": Literal["TakeoffLocation", "GroundLevel"],
    },
)

RIDRecentAircraftPosition = TypedDict(
    "RIDRecentAircraftPosition",
    {
        "time": "RIDTime",
        "position": "PastPosition",
    },
)

RIDTime = TypedDict(
    "RIDTime",
    {
        "value": str,
        "format": Literal["RFC3339"],
    },
)

RadarPlace = TypedDict(
    "RadarPlace",
    {
        "east_m": float,
        "north_m": float,
        "east_sigma_m": float,
        "north_sigma_m": float,
        "latitude_deg": float,
        "longitude_deg": float,
        "bearing_correction_deg": float,
        "drone_minutes": float,
        "contradicts": bool,
    },
)

Raw = TypedDict(
    "Raw",
    {
        "type": Union[Literal["FeatureCollection"]],
        "last": int,
        "features": list["FeatureOfReportProperties"],
    },
)

Receiver = TypedDict(
    "Receiver",
    {
        "version": str,
        "refresh": int,
        "history": int,
        "lat": NotRequired[float],
        "lon": NotRequired[float],
    },
)

RecentTrail = TypedDict(
    "RecentTrail",
    {
        "times": list[str],
        "coordinates": list["Position"],
    },
)

Refused = TypedDict(
    "Refused",
    {
        "sensor": Union[str, None],
        "reason": str,
        "count": int,
    },
)

Registration = TypedDict(
    "Registration",
    {
        "mode": Literal["apply", "propose", "off"],
        "applied": bool,
        "tracks": NotRequired[float],
        "shared_minutes": NotRequired[float],
        "residual": NotRequired[float],
        "bearing_deg": NotRequired["RegistrationValue"],
        "tilt_east_deg": NotRequired["RegistrationValue"],
        "tilt_north_deg": NotRequired["RegistrationValue"],
        "range_m": NotRequired["RegistrationValue"],
        "height_m": NotRequired["RegistrationValue"],
        "time_s": NotRequired["RegistrationValue"],
        "hint": NotRequired[str],
        "alarm": NotRequired[str],
        "step": NotRequired["RegistrationStep"],
        "place": NotRequired["RadarPlace"],
        "relocated": NotRequired["RelocatedRadar"],
    },
)

RegistrationStep = TypedDict(
    "RegistrationStep",
    {
        "time": str,
        "before": "RegistrationValues",
        "after": "RegistrationValues",
    },
)

RegistrationValue = TypedDict(
    "RegistrationValue",
    {
        "value": float,
        "deviation": float,
        "observable": bool,
    },
)

RegistrationValues = TypedDict(
    "RegistrationValues",
    {
        "bearing_deg": "RegistrationValue",
        "tilt_east_deg": "RegistrationValue",
        "tilt_north_deg": "RegistrationValue",
        "range_m": "RegistrationValue",
        "height_m": "RegistrationValue",
        "time_s": "RegistrationValue",
    },
)

RelocatedRadar = TypedDict(
    "RelocatedRadar",
    {
        "east_m": float,
        "north_m": float,
        "bearing_deg": float,
        "latitude_deg": float,
        "longitude_deg": float,
    },
)

Relocation = TypedDict(
    "Relocation",
    {
        "sensor": str,
        "east_m": float,
        "north_m": float,
        "bearing_deg": float,
        "since": str,
    },
)

Relocations = TypedDict(
    "Relocations",
    {
        "relocations": list["Relocation"],
    },
)

RemoteIdDeclaration = TypedDict(
    "RemoteIdDeclaration",
    {
        "ua_type": NotRequired[Literal["NotDeclared", "Aeroplane", "Helicopter", "Gyroplane", "HybridLift", "Ornithopter", "Glider", "Kite", "FreeBalloon", "CaptiveBalloon", "Airship", "FreeFallOrParachute", "Rocket", "TetheredPoweredAircraft", "GroundObstacle", "Other"]],
        "operational_status": NotRequired[Literal["Undeclared", "Ground", "Airborne", "Emergency", "RemoteIDSystemFailure"]],
        "height": NotRequired["RIDHeight"],
        "operator_id": NotRequired[str],
        "operator_location": NotRequired["OperatorPlace"],
    },
)

RemoteIdLine = TypedDict(
    "RemoteIdLine",
    {
        "time": NotRequired[Union[Union[float, str], None]],
        "transmitter": str,
        "rssi": NotRequired[Union[float, None]],
        "receiver": NotRequired[Union[str, None]],
        "message": str,
    },
)

RemoteIdPosted = TypedDict(
    "RemoteIdPosted",
    {
        "lines": int,
        "taken": int,
        "refused": dict[str, int],
    },
)

Replay = TypedDict(
    "Replay",
    {
        "playing": bool,
        "speed": float,
        "ended": bool,
        "time": NotRequired[str],
        "start": NotRequired[str],
        "end": NotRequired[str],
    },
)

ReportProperties = TypedDict(
    "ReportProperties",
    {
        "kind": NotRequired[Literal["transponder"]],
        "track_number": NotRequired[int],
        "uav_probability": NotRequired[float],
        "serial_number": NotRequired[str],
        "sensor": str,
        "time": str,
    },
)

Resync = TypedDict(
    "Resync",
    {
        "reason": str,
    },
)

SensorProperties = TypedDict(
    "SensorProperties",
    {
        "id": str,
        "kind": Literal["radar", "transponder", "adsb", "remote-id", "camera"],
        "sac": NotRequired[int],
        "sic": NotRequired[int],
        "state": NotRequired[Literal["operational", "degraded", "outage"]],
        "reasons": NotRequired[list[str]],
        "rate_hz": NotRequired[float],
        "accepted": NotRequired[int],
        "refused": NotRequired[dict[str, int]],
        "lines": NotRequired[list["Line"]],
        "last_seen": NotRequired[str],
        "clock_offset_s": NotRequired[float],
        "contested": NotRequired[list["Contested"]],
        "registration": NotRequired["Registration"],
        "orientation": NotRequired["CameraOrientation"],
        "learnt": NotRequired["Learnt"],
        "transponder_types": NotRequired[list["LearntTransponderType"]],
    },
)

Sensors = TypedDict(
    "Sensors",
    {
        "type": Union[Literal["FeatureCollection"]],
        "unknown": list["UnknownSource"],
        "features": list["FeatureOfSensorProperties"],
        "time": NotRequired[str],
    },
)

ServiceStatus = TypedDict(
    "ServiceStatus",
    {
        "time": str,
        "state": Literal["ok", "degraded"],
        "ready": bool,
        "reasons": list[str],
        "started": str,
        "uptime_s": float,
        "seq": int,
        "streams": int,
        "late_s": NotRequired[float],
        "state_failing": list[str],
        "latency_s": NotRequired["Quantiles"],
        "lateness_s": NotRequired["Quantiles"],
        "failed_sends": NotRequired[int],
        "tally": NotRequired["Tally"],
    },
)

Settings = TypedDict(
    "Settings",
    {
        "motion": Literal["imm", "singer"],
        "window_s": float,
        "max_future_s": float,
        "max_gap_s": float,
        "threshold_m": list[list[float]],
        "ratio_min": float,
        "min_samples": int,
        "weight_radar": float,
        "weight_transponder": float,
        "radar_only_min_s": float,
        "suppress_s": float,
    },
)

Site = TypedDict(
    "Site",
    {
        "name": str,
        "sac": int,
        "sic": int,
    },
)

Skipped = TypedDict(
    "Skipped",
    {
        "category": int,
        "count": int,
    },
)

Snapshot = TypedDict(
    "Snapshot",
    {
        "type": Union[Literal["FeatureCollection"]],
        "time": str,
        "site": str,
        "numberMatched": int,
        "numberReturned": int,
        "features": list["FeatureOfPastProperties"],
    },
)

SpatialExtent = TypedDict(
    "SpatialExtent",
    {
        "bbox": list[list[float]],
        "crs": Literal["http://www.opengis.net/def/crs/OGC/1.3/CRS84"],
    },
)

StreamMessageSnapshot = TypedDict(
    "StreamMessageSnapshot",
    {
        "event": Literal["snapshot"],
        "id": str,
        "data": "Tracks",
    },
)

StreamMessageTracks = TypedDict(
    "StreamMessageTracks",
    {
        "event": Literal["tracks"],
        "id": str,
        "data": "Tracks",
    },
)

StreamMessageEnded = TypedDict(
    "StreamMessageEnded",
    {
        "event": Literal["ended"],
        "id": str,
        "data": "Ended",
    },
)

StreamMessageSensor = TypedDict(
    "StreamMessageSensor",
    {
        "event": Literal["sensor"],
        "id": str,
        "data": "SensorProperties",
    },
)

StreamMessageIntegrity = TypedDict(
    "StreamMessageIntegrity",
    {
        "event": Literal["integrity"],
        "id": str,
        "data": "IdentityIntegrity",
    },
)

StreamMessageAlert = TypedDict(
    "StreamMessageAlert",
    {
        "event": Literal["alert"],
        "id": str,
        "data": "Alert",
    },
)

StreamMessageConflict = TypedDict(
    "StreamMessageConflict",
    {
        "event": Literal["conflict"],
        "id": str,
        "data": "Conflict",
    },
)

StreamMessageHeartbeat = TypedDict(
    "StreamMessageHeartbeat",
    {
        "event": Literal["heartbeat"],
        "id": str,
        "data": "Heartbeat",
    },
)

StreamMessageResync = TypedDict(
    "StreamMessageResync",
    {
        "event": Literal["resync"],
        "id": str,
        "data": "Resync",
    },
)

StreamMessageClosed = TypedDict(
    "StreamMessageClosed",
    {
        "event": Literal["closed"],
        "id": str,
        "data": "Closed",
    },
)

StreamMessage = Union["StreamMessageSnapshot", "StreamMessageTracks", "StreamMessageEnded", "StreamMessageSensor", "StreamMessageIntegrity", "StreamMessageAlert", "StreamMessageConflict", "StreamMessageHeartbeat", "StreamMessageResync", "StreamMessageClosed"]

Tally = TypedDict(
    "Tally",
    {
        "received": int,
        "octets": int,
        "duplicates": int,
        "accepted": dict[str, int],
        "service": dict[str, int],
        "faults": list["Fault"],
        "refused": list["Refused"],
        "skipped": list["Skipped"],
        "several_records": int,
        "unknown_sources": int,
        "restarts": int,
        "clock_behind": int,
        "dropped": int,
    },
)

Threshold = TypedDict(
    "Threshold",
    {
        "join": float,
        "part": float,
    },
)

Ticket = TypedDict(
    "Ticket",
    {
        "ticket": str,
        "expires_in_s": int,
    },
)

Tiles = TypedDict(
    "Tiles",
    {
        "url": str,
        "attribution": str,
    },
)

TrackProperties = TypedDict(
    "TrackProperties",
    {
        "id": str,
        "name": NotRequired[str],
        "source": Literal["fused", "radar", "transponder", "camera"],
        "track_number": int,
        "state": Literal["active", "coasting"],
        "time": str,
        "lat": float,
        "lng": float,
        "alt": NotRequired[float],
        "alt_msl": NotRequired[float],
        "geoid_separation": float,
        "speed": NotRequired[float],
        "track": NotRequired[float],
        "vertical_speed": NotRequired[float],
        "accuracy_h_m": NotRequired[float],
        "accuracy_v_m": NotRequired[float],
        "accuracy_h": NotRequired[Literal["HA1m", "HA3m", "HA10m", "HA30m", "HA005NM", "HA01NM", "HA03NM", "HA05NM", "HA1NM", "HA2NM", "HA4NM", "HA10NM", "HA10NMPlus"]],
        "accuracy_v": NotRequired[Literal["VA1m", "VA3m", "VA10m", "VA25m", "VA45m", "VA150m", "VA150mPlus"]],
        "accuracy_ellipse": NotRequired["Ellipse"],
        "interpolated": bool,
        "extrapolated": bool,
        "uav_probability": NotRequired[float],
        "aircraft_type": Literal["drone", "crewed", "vehicle", "other", "unknown"],
        "uas_id": NotRequired["UasId"],
        "aircraft": NotRequired["AircraftJson"],
        "remote_id": NotRequired["RemoteIdDeclaration"],
        "also": NotRequired[list["Also"]],
        "integrity": NotRequired[Literal["unverified", "verified", "suspect", "failed"]],
        "integrity_index": NotRequired[float],
        "protection_level_m": NotRequired[float],
        "offset_m": NotRequired[float],
        "reasons": NotRequired[list[Literal["radar", "jump", "frozen", "replay", "duplicate", "swapped", "velocity", "time"]]],
        "linked": NotRequired[list["Link"]],
        "uncooperative": NotRequired[bool],
        "first_seen": str,
        "last_measurement": NotRequired[str],
        "contributors": list["Contributor"],
        "age_s": float,
        "trail": NotRequired["RecentTrail"],
    },
)

Tracks = TypedDict(
    "Tracks",
    {
        "type": Union[Literal["FeatureCollection"]],
        "at": NotRequired[Literal["now"]],
        "time": NotRequired[str],
        "published_at": NotRequired[str],
        "latency_s": NotRequired[float],
        "seq": int,
        "site": str,
        "numberMatched": int,
        "numberReturned": int,
        "next": NotRequired[str],
        "features": list["FeatureOfTrackProperties"],
    },
)

TrailProperties = TypedDict(
    "TrailProperties",
    {
        "id": str,
        "times": list[str],
        "sources": list[Literal["fused", "radar", "transponder", "camera"]],
        "alt_msl": list[Union[float, None]],
    },
)

TransponderId = TypedDict(
    "TransponderId",
    {
        "serial_number": str,
        "registration_country": NotRequired[str],
    },
)

UasId = TypedDict(
    "UasId",
    {
        "serial_number": NotRequired[str],
        "registration_id": NotRequired[str],
        "utm_id": NotRequired[str],
        "specific_session_id": NotRequired[str],
        "manufacturer": NotRequired[str],
        "model": NotRequired[str],
        "registration_country": NotRequired[str],
    },
)

UnknownSource = TypedDict(
    "UnknownSource",
    {
        "category": int,
        "sac": int,
        "sic": int,
        "own": bool,
        "records": int,
        "last_seen": str,
    },
)

Volume = TypedDict(
    "Volume",
    {
        "name": str,
        "horizontal_m": float,
        "vertical_m": float,
        "tau_s": float,
    },
)

Zone = TypedDict(
    "Zone",
    {
        "name": str,
        "activated_by": str,
        "activated_at": str,
        "floor_m": NotRequired[float],
        "ceiling_m": NotRequired[float],
    },
)

ZoneLimits = TypedDict(
    "ZoneLimits",
    {
        "name": NotRequired[Union[str, None]],
        "floor_m": NotRequired[Union[float, None]],
        "ceiling_m": NotRequired[Union[float, None]],
    },
)

Zones = TypedDict(
    "Zones",
    {
        "available": bool,
        "zones": list["Zone"],
    },
)
