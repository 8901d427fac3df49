"""A simulated flight, and the program that comes with the package."""

import json
import signal
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path

import pytest
import utm_fusion

HERE = Path(__file__).parent


@pytest.fixture(scope="session")
def scenario():
    return HERE / "everything.toml"


@pytest.fixture(scope="session")
def flight(tmp_path_factory, scenario):
    return utm_fusion.simulate(scenario, tmp_path_factory.mktemp("flight"), seed=7)


@pytest.fixture(scope="session")
def program():
    def run(*arguments, check=True):
        command = [sys.executable, "-m", "utm_fusion", *map(str, arguments)]
        return subprocess.run(command, check=check, capture_output=True, text=True)

    return run


@pytest.fixture(scope="session")
def decoded(program):
    """The output of the program's `decode` as objects."""

    def lines(*arguments):
        done = program("decode", *arguments, check=False)
        return [json.loads(line) for line in done.stdout.splitlines()]

    return lines


def damaged(path):
    """The octets of a raw file, damaged in the same way each time."""
    octets = bytearray(path.read_bytes())
    for at in range(1000, len(octets), 577):
        octets[at] ^= 0xA5
    del octets[5000:5003]
    return bytes(octets)


@contextmanager
def ctrl_c(after_s):
    """Sends Ctrl-C once, which must take effect within five seconds."""
    presses = threading.Timer(after_s, signal.raise_signal, [signal.SIGINT])
    # Background processes of a script ignore the signal.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    presses.start()
    start = time.monotonic()
    try:
        with pytest.raises(KeyboardInterrupt):
            yield
    finally:
        presses.cancel()
        signal.signal(signal.SIGINT, before)
    assert time.monotonic() - start < after_s + 5
