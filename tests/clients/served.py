"""A vehicle of `sil serve` for as long as a `with` block lasts, at a TCP port of its own."""

import subprocess
import sys
import threading
import time


class Served:
    """Starts `sil serve` and finds its port in what it prints."""

    def __init__(self, sil, *arguments, udp="off", seconds=120):
        self.command = [sil, "serve", "--tcp", "0", "--udp", udp, "--for", str(seconds), *arguments]

    def __enter__(self):
        self.process = subprocess.Popen(self.command, stdout=subprocess.PIPE, text=True)
        for line in self.process.stdout:
            if line.startswith("TCP  waits for clients at "):
                self.port = int(line.rsplit(":", 1)[1])
                # nobody reads on: what else it prints must not fill the pipe
                threading.Thread(target=self.process.stdout.read, daemon=True).start()
                return self
        raise SystemExit(f"{' '.join(self.command)} ended without a port")

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait()


def expect(holds, words):
    """Ends the test if something does not hold."""
    if not holds:
        print(f"FAILED: {words}")
        sys.exit(1)


class Stopwatch:
    """Says how long things took, a line each."""

    def __init__(self):
        self.start = time.monotonic()

    def lap(self, words):
        now = time.monotonic()
        print(f"  {1000 * (now - self.start):7.0f} ms  {words}", flush=True)
        self.start = now
