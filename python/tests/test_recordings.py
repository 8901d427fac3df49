"""Real recordings, from the folder that UTM_FUSION_SHARED_DATA names."""

import os
import warnings
from pathlib import Path

import pytest
import utm_fusion

ROOT = os.environ.get("UTM_FUSION_SHARED_DATA")
KINDS = {".ast", ".pcap", ".pcapng", ".ff", ".beast", ".raw", ".bin"}
CAPTURES = sorted(path for path in Path(ROOT).rglob("*") if path.suffix in KINDS) if ROOT else []


@pytest.mark.skipif(not ROOT, reason="UTM_FUSION_SHARED_DATA is not set")
def test_there_are_some():
    assert len(CAPTURES) > 20


@pytest.mark.parametrize("path", CAPTURES, ids=lambda path: path.name)
def test_records_are_what_decode_prints(path, decoded):
    found = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", utm_fusion.InputWarning)
        try:
            found.extend(utm_fusion.records(path))
        except utm_fusion.Error:
            pass  # No records if the file is no capture; the records before the damage if it is damaged.
    expected = decoded(path)
    assert len(found) == len(expected)
    for record, line in zip(found, expected):
        assert repr(record) == repr(line)
