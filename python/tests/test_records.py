import gzip

import pytest
import utm_fusion
from conftest import ctrl_c, damaged
from utm_fusion import Error, InputWarning


@pytest.mark.parametrize("name", ["capture", "radar", "transponder"])
def test_records_are_what_decode_prints(flight, decoded, name):
    expected = decoded(flight[name])
    assert len(expected) > 50
    assert list(utm_fusion.records(flight[name])) == expected
    # Equal numbers of the same type, and keys in the same order.
    assert repr(list(utm_fusion.records(flight[name]))) == repr(expected)


def test_a_capture_has_every_kind_of_record(flight):
    kinds = {record.get("cat", record.get("message")) for record in utm_fusion.records(flight["capture"])}
    assert {34, 48, 129, 21, "location"} <= kinds


def test_options_are_those_of_decode(flight, decoded):
    path = flight["capture"]
    for options, arguments in [
        ({"cat": 48}, ["--cat", 48]),
        ({"cat": 48, "edition": "1.31"}, ["--cat", 48, "--edition", "1.31"]),
        ({"edition": ["21:2.1", "48:1.30"]}, ["--edition", "21:2.1", "--edition", "48:1.30"]),
        ({"untyped": True}, ["--untyped"]),
        ({"cat": 129, "hex": True}, ["--cat", 129, "--hex"]),
    ]:
        assert list(utm_fusion.records(path, **options)) == decoded(path, *arguments)


def test_octets_are_read_as_a_file_is(flight):
    path = flight["capture"]
    expected = list(utm_fusion.records(str(path)))
    assert list(utm_fusion.records(path.read_bytes())) == expected
    assert list(utm_fusion.records(gzip.compress(path.read_bytes()))) == expected


def test_what_cannot_be_read_is_told(flight, decoded, program, tmp_path):
    path = tmp_path / "damaged.ast"
    path.write_bytes(damaged(flight["radar"]))
    expected = decoded(path)
    records = utm_fusion.records(path)
    with pytest.warns(InputWarning) as warned:
        assert list(records) == expected
    assert sum("error" in record for record in expected) == sum(records.faults.values()) > 15
    said = program("decode", path, check=False).stderr.splitlines()
    assert str(warned[0].message) == "; ".join(said)
    errors = [record for record in expected if "error" in record]
    with pytest.warns(InputWarning):
        assert list(utm_fusion.records(path, errors_only=True)) == errors


def test_a_capture_that_breaks_off_loses_nothing_before(flight, program, tmp_path):
    path = tmp_path / "cut.pcap"
    path.write_bytes(flight["capture"].read_bytes()[:-20])
    whole = list(utm_fusion.records(flight["capture"]))
    records, found = utm_fusion.records(path), []
    with pytest.raises(Error) as raised:
        for record in records:
            found.append(record)
    assert found == whole[: len(found)] and len(whole) - 20 < len(found) < len(whole)
    assert program("decode", path, check=False).stderr.strip() == f"utm-fusion: {raised.value}"
    assert list(records) == [], "it is over"


def test_errors_are_in_the_words_of_the_program(tmp_path, program):
    (tmp_path / "text.ast").write_text("no capture at all, but long enough to be looked at")
    for path in [tmp_path / "missing.pcap", tmp_path / "text.ast", tmp_path]:
        with pytest.raises(Error) as raised:
            utm_fusion.records(path)
        assert program("decode", path, check=False).stderr.strip() == f"utm-fusion: {raised.value}"
    with pytest.raises(Error, match='"9.9" is no edition of CAT048'):
        utm_fusion.records(tmp_path, cat=48, edition="9.9")
    with pytest.raises(OverflowError):
        utm_fusion.records(tmp_path, cat=256)


def test_ctrl_c_ends_what_finds_nothing(flight, tmp_path):
    path = tmp_path / "long.ast"
    path.write_bytes(flight["radar"].read_bytes() * 400)
    # No record has this category, so the first call returns only at the end.
    with ctrl_c(0.1):
        while True:
            next(utm_fusion.records(path, cat=200), None)


@pytest.mark.parametrize("name", ["capture", "radar", "transponder"])
def test_what_was_decoded_is_encoded_again(flight, name):
    raw = [record for record in utm_fusion.records(flight[name]) if "cat" in record]
    octets = utm_fusion.encode(raw)
    if name != "capture":
        assert octets == flight[name].read_bytes()
    assert [record["items"] for record in utm_fusion.records(octets)] == [record["items"] for record in raw]


def test_records_are_made_by_hand():
    record = {"cat": 48, "items": {"010": {"sac": 25, "sic": 200}, "040": {"rho_m": 1852, "theta_deg": 90}}}
    octets = utm_fusion.encode(record)
    assert octets == bytes.fromhex("30000a" + "90" + "19c8" + "01004000")
    assert next(utm_fusion.records(octets))["items"]["040"] == {"rho_m": 1852.0, "theta_deg": 90.0}
    with pytest.raises(Error, match="record 1: item 040: "):
        utm_fusion.encode([record, {"cat": 48, "items": {"040": {"rho_m": 1e9, "theta_deg": 0}}}])
