"""The program `utm-fusion`: python -m utm_fusion decode capture.pcap"""

import signal
import sys

from ._native import main as run


def main() -> None:
    # As in the program: Ctrl-C ends the process.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(run(["utm-fusion", *sys.argv[1:]]))


if __name__ == "__main__":
    main()
