"""MAVProxy without a screen: connects and loads the parameters."""

import sys
import tempfile

from served import Served, Stopwatch, expect, mavproxy


def main():
    with Served(sys.argv[1]) as served, tempfile.TemporaryDirectory() as folder:
        watch = Stopwatch()
        found = mavproxy(f"tcp:127.0.0.1:{served.port}", "param,arm,mode", folder, until="Received", patience_s=20)
        expect("77 parameters" in found, f"all parameters loaded: {found}")
        watch.lap(found)


main()
