"""A vehicle of `sil serve` for as long as a `with` block lasts, at a TCP port of its own."""

import pathlib
import subprocess
import sys
import threading
import time


class Served:
    """Starts `sil serve` and finds its port in what it prints."""

    def __init__(self, sil, *arguments, udp="off", seconds=120):
        self.lines = []
        self.command = [sil, "serve", "--tcp", "0", "--udp", udp, "--for", str(seconds), *arguments]

    def __enter__(self):
        self.process = subprocess.Popen(self.command, stdout=subprocess.PIPE, text=True)
        for line in self.process.stdout:
            if line.startswith("TCP  waits for clients at "):
                self.port = int(line.rsplit(":", 1)[1])
                # somebody reads on: what else it prints must not fill the pipe
                threading.Thread(target=lambda: self.lines.extend(self.process.stdout), daemon=True).start()
                return self
        raise SystemExit(f"{' '.join(self.command)} ended without a port")

    def wait(self, patience_s=120):
        """Until it ends by itself."""
        self.process.wait(patience_s)

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait()


class Board:
    """The emulated board, which executes the firmware's own ELF: TELEM1 and USB each at a TCP port, for one client at a
    time; in its slot an empty card. Effects are what its vehicle is beyond the one that it takes it for."""

    def __init__(self, server, elf, *effects):
        self.command, self.lines = [server, elf, "0", "0", *effects], []

    def __enter__(self):
        self.process = subprocess.Popen(self.command, stdout=subprocess.PIPE, text=True)
        self.port, self.usb_port = [self.found(name) for name in ["TELEM1", "USB"]]
        threading.Thread(target=lambda: self.lines.extend(self.process.stdout), daemon=True).start()
        return self

    def found(self, name):
        """The port that its next line says."""
        line = self.process.stdout.readline()
        if not line.startswith(f"{name} at tcp:"):
            raise SystemExit(f"{' '.join(self.command)} ended without a port")
        return int(line.rsplit(":", 1)[1])

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait()

    def speed(self):
        """Its own time over real time, as it says last."""
        said = [line for line in self.lines if "times real time" in line]
        return said[-1].split(" at ")[1].strip() if said else "unknown"


def mavproxy(master, modules, folder, *arguments, until, patience_s):
    """Runs MAVProxy without a screen until a line that it prints has `until` in it, which is returned, and ends it."""
    path = pathlib.Path(sys.executable).with_name("mavproxy.py")
    command = [sys.executable, str(path), "--master", master, "--non-interactive", "--default-modules", modules,
               "--state-basedir", folder, "--aircraft", "sil", *arguments]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                               text=True, cwd=folder)
    lines = []
    threading.Thread(target=lambda: lines.extend(process.stdout), daemon=True).start()
    try:
        end = time.monotonic() + patience_s
        while time.monotonic() < end and not any(until in line for line in lines):
            time.sleep(0.1)
    finally:
        process.kill()
        process.wait()
    found = [line.strip() for line in lines if until in line]
    expect(found, f"MAVProxy says {until!r}: {''.join(lines)}")
    return found[0]


# pymavlink's dialects have no COMPONENT_METADATA: its bytes are all that is seen of it
COMPONENT_METADATA = 397


def component_metadata(message):
    """CRC and address of the general file in a COMPONENT_METADATA."""
    payload = bytes(message.data)[10:-2]
    return int.from_bytes(payload[4:8], "little"), payload[8:].rstrip(b"\0").decode()


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
