"""MAVProxy without a screen: connects and loads the parameters."""

import sys
import tempfile

from served import Served, Stopwatch, expect, mavproxy


def loads_parameters(port, watch):
    with tempfile.TemporaryDirectory() as folder:
        found = mavproxy(f"tcp:127.0.0.1:{port}", "param,arm,mode", folder, until="Received", patience_s=30)
        expect("80 parameters" in found, f"all parameters loaded: {found}")
        watch.lap(found)


def main():
    with Served(sys.argv[1]) as served:
        loads_parameters(served.port, Stopwatch())


if __name__ == "__main__":
    main()
