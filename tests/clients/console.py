"""MAVProxy without a screen: connects and loads the parameters."""

import pathlib
import subprocess
import sys
import tempfile
import threading
import time

from served import Served, Stopwatch, expect


def main():
    mavproxy = pathlib.Path(sys.executable).with_name("mavproxy.py")
    with Served(sys.argv[1]) as served, tempfile.TemporaryDirectory() as folder:
        watch = Stopwatch()
        command = [sys.executable, str(mavproxy), "--master", f"tcp:127.0.0.1:{served.port}", "--non-interactive",
                   "--default-modules", "param,arm,mode", "--state-basedir", folder, "--aircraft", "sil"]
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                   text=True, cwd=folder)
        lines = []
        threading.Thread(target=lambda: lines.extend(process.stdout), daemon=True).start()
        try:
            until = time.monotonic() + 20
            while time.monotonic() < until and not any("Received" in line for line in lines):
                time.sleep(0.1)
        finally:
            process.kill()
            process.wait()
        found = [line.strip() for line in lines if "Received" in line]
        expect(found and "77 parameters" in found[0], f"all parameters loaded: {''.join(lines)}")
        watch.lap(found[0])


main()
