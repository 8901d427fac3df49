"""Time to read records as dicts and as columns, compared with asterix_decoder (PyPI): python3 figures.py CAPTURE [CATEGORY]

Each call runs in its own process, which first reads the capture into memory. The printed time is the user CPU time of the call
only: the median of five rounds, in which the calls alternate.
"""

import statistics
import subprocess
import sys
from pathlib import Path

CALLS = {
    "asterix_decoder, as it comes": "import asterix as m; f = lambda: m.parse(octets)",
    "asterix_decoder, verbose=False": "import asterix as m; f = lambda: m.parse(octets, verbose=False)",
    "list(records(octets))": "import utm_fusion as m; f = lambda: list(m.records(octets))",
    "for record in records(octets)": "import utm_fusion as m; f = lambda: sum(1 for _ in m.records(octets)) * [0]",
    "table(octets, category)": "import utm_fusion as m; f = lambda: m.table(octets, category)",
    "plots(octets)": "import utm_fusion as m; f = lambda: m.plots(octets)",
}
PROGRAM = """
import resource, sys
octets, category = open(sys.argv[1], "rb").read(), int(sys.argv[2])
{call}
user = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_utime
start = user()
count = len(f())
print(count, user() - start)
"""


def main() -> None:
    path, category = Path(sys.argv[1]), sys.argv[2] if len(sys.argv) > 2 else "48"
    seconds: dict[str, list[float]] = {name: [] for name in CALLS}
    counts = {}
    for _ in range(5):
        for name, call in CALLS.items():
            command = [sys.executable, "-c", PROGRAM.format(call=call), str(path), category]
            done = subprocess.run(command, check=True, capture_output=True, text=True)
            count, took = done.stdout.split()
            counts[name] = int(count)
            seconds[name].append(float(took))
    usual, lean = (statistics.median(seconds[name]) for name in list(CALLS)[:2])
    print(f"{'':32} {'rows':>8} {'user s':>8} {'times':>6} {'times lean':>10}")
    for name, took in seconds.items():
        median = statistics.median(took)
        print(f"{name:32} {counts[name]:8} {median:8.3f} {usual / median:6.0f} {lean / median:10.0f}")


if __name__ == "__main__":
    main()
