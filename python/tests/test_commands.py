import json

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import utm_fusion
from conftest import ctrl_c
from utm_fusion import Error, InputWarning


def test_simulations_are_those_of_the_program(flight, scenario, program, tmp_path):
    program("simulate", scenario, "--seed", 7, "--out", tmp_path / "out")
    files = sorted((tmp_path / "out").iterdir())
    assert sorted(path.name for path in flight.values()) == [path.name for path in files]
    for path in files:
        assert flight[path.stem].read_bytes() == path.read_bytes(), path.name


def test_a_scenario_may_last_another_time(scenario, program, tmp_path):
    shorter = tmp_path / "shorter.toml"
    shorter.write_text(scenario.read_text().replace("duration_s = 60", "duration_s = 30"))
    program("simulate", shorter, "--out", tmp_path / "there")
    files = utm_fusion.simulate(scenario, tmp_path / "here", duration_s=30)
    assert files["capture"].read_bytes() == (tmp_path / "there/capture.pcap").read_bytes()

    with pytest.raises(Error, match="duration_s 5"):
        utm_fusion.simulate(scenario, tmp_path, duration_s=5)
    with pytest.raises(Error, match="missing.toml"):
        utm_fusion.simulate(tmp_path / "missing.toml", tmp_path)


@pytest.mark.parametrize(
    "options", [{}, {"profile": "reference"}, {"at": "now"}], ids=["operational", "reference", "now"]
)
def test_replay_is_that_of_the_program(flight, program, tmp_path, options):
    arguments = [argument for key, value in options.items() for argument in (f"--{key}", value)]
    fused = utm_fusion.replay(flight["capture"], flight["site"], output=tmp_path / "here.ndjson", **options)
    for name in ["there.parquet", "there.ndjson"]:
        program("replay", flight["capture"], "--config", flight["site"], "-o", tmp_path / name, *arguments)
    expected = pq.read_table(tmp_path / "there.parquet")
    assert expected.num_rows > 100
    assert pa.table(fused).cast(expected.schema).equals(expected)
    assert (tmp_path / "here.ndjson").read_bytes() == (tmp_path / "there.ndjson").read_bytes()


def test_replay_takes_octets_and_several_captures(flight):
    whole = pa.table(utm_fusion.replay(flight["capture"].read_bytes(), flight["site"]))
    assert whole.equals(pa.table(utm_fusion.replay(flight["capture"], flight["site"])))
    both = utm_fusion.replay([flight["radar"], flight["transponder"]], flight["site"], date="2026-03-14")
    assert len(both) > 100
    with pytest.warns(InputWarning, match="has no date"):
        utm_fusion.replay(flight["transponder"], flight["site"])


def test_replay_fails_in_the_words_of_the_program(flight, program, tmp_path):
    site = tmp_path / "site.toml"
    for old, new in [("sic = ", "sic = 1"), ("[site]", "[sites]")]:
        site.write_text(flight["site"].read_text().replace(old, new))
        with pytest.raises(Error) as raised:
            utm_fusion.replay(flight["radar"], site, date="2026-03-14")
        done = program("replay", flight["radar"], "--config", site, "--date", "2026-03-14", check=False)
        assert done.returncode in (1, 3) and str(raised.value) in done.stderr
    with pytest.raises(Error, match="at soon"):
        utm_fusion.replay(flight["radar"], flight["site"], at="soon")


def test_ctrl_c_ends_a_replay(flight):
    with ctrl_c(0.03):
        utm_fusion.replay([flight["capture"]] * 200, flight["site"])


def test_scores_are_those_of_the_program(flight, program, tmp_path):
    fused = tmp_path / "fused.ndjson"
    utm_fusion.replay(flight["capture"], flight["site"], output=fused)
    files = {name: flight[key] for name, key in [("labels", "labels"), ("capture", "capture"), ("config", "site")]}
    scores = utm_fusion.evaluate(fused, flight["truth"], **files)
    arguments = [argument for key, value in files.items() for argument in (f"--{key}", value)]
    done = program("evaluate", fused, "--truth", flight["truth"], "--json", *arguments)
    assert scores == json.loads(done.stdout)
    assert scores["fused"]["all"]["pu_percent"] > 50
    with pytest.raises(Error, match="capture needs config"):
        utm_fusion.evaluate(fused, flight["truth"], capture=flight["capture"])
    with pytest.raises(Error, match="exchanged"):
        utm_fusion.evaluate(flight["truth"], fused)


def test_warnings_of_the_program_are_warnings(flight, tmp_path):
    fused = tmp_path / "other.ndjson"
    utm_fusion.replay(flight["radar"], flight["site"], date="2020-01-01", output=fused)
    with pytest.warns(InputWarning, match="no point counts"):
        utm_fusion.evaluate(fused, flight["truth"])


def test_the_program_is_there(program):
    assert program("--version").stdout == f"utm-fusion {utm_fusion.__version__}\n"
    assert program("decode", check=False).returncode == 2
