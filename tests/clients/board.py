"""The clients that meet `sil serve`, and the emulated board: the firmware's own ELF, with TELEM1 at a TCP port.

The board comes as from its maker: blank memory, 57,600 baud. Its owner confirms the configuration, as
docs/first-connection.md says; then QGroundControl's connect sequence, the parameters' descriptions, MAVProxy and a
companion by MAVSDK follow, as against `sil serve`, but for what a line of that rate does not carry.
"""

import asyncio
import pathlib
import sys
import tempfile
import time

import companion
import connect
import console
import metadata
from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mavlink
from served import Board, Stopwatch, expect

# of power-on or a restart until the gyro is calibrated
REST_S = 5.0
# from power-on until the board is heard, over USB until a computer has found the port; on a busy computer
FOUND_S = 10


def owner(ground, watch):
    """Refused on purpose, and why; then confirmed."""
    deadline = time.monotonic() + REST_S
    while time.monotonic() < deadline:
        ground.link.recv_match(blocking=True, timeout=0.1)
    expect(ground.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1) == connect.REJECTED, "not armed unconfirmed")
    text = ground.wait("STATUSTEXT", lambda text: text.text.startswith("refused"))
    expect(text is not None and "confirm defaults" in text.text, f"the reason in words: {text}")
    expect(ground.command(mavlink.MAV_CMD_PREFLIGHT_STORAGE, 1) == connect.ACCEPTED, "confirmed")
    watch.lap(f"a new board: \"{text.text}\", confirmed")


def stay(ground, seconds):
    """Does nothing but be there."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        ground.beat()
        ground.wait("HEARTBEAT", patience_s=1)


def arm(ground, patience_s=60):
    """As soon as it may be: on a busy computer the board is slower than time."""
    until, result = time.monotonic() + patience_s, None
    while result != connect.ACCEPTED and time.monotonic() < until:
        ground.beat()
        ground.wait("HEARTBEAT", patience_s=1)
        result = ground.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1)
    expect(result == connect.ACCEPTED, f"armed within {patience_s} s")


def describes_itself(port, watch):
    with tempfile.TemporaryDirectory() as folder:
        link = mavutil.mavlink_connection(f"tcp:127.0.0.1:{port}", source_system=255)
        by_name, file, reader = metadata.describe(link, folder, watch)
        expect(reader.crc(file["uri"]) == file["fileCrc"], "CalcFileCRC32 says the same")
        metadata.held_against_list(by_name, metadata.values(link))
        metadata.refuses_outside(link, by_name)
        link.close()
        watch.lap(f"{len(by_name)} parameters as described, nothing outside is taken")
        found = asyncio.run(metadata.by_mavsdk(port))
        expect({one["name"]: one for one in found["parameters"]} == by_name, "MAVSDK reads the same")
        watch.lap("MAVSDK reads the same")


def main():
    start = time.monotonic()
    with Board(*sys.argv[1:3]) as board:
        watch = Stopwatch()
        ground = connect.Ground(board.port, FOUND_S)
        owner(ground, watch)
        connect.connect(ground, watch)
        connect.answers(ground, watch)
        # 50 Hz of it are more than 57,600 baud have room for
        expect(ground.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, mavlink.MAVLINK_MSG_ID_HIGHRES_IMU, 10_000)
               == connect.REJECTED, "100 HIGHRES_IMU a second: no room")
        connect.intervals(ground, watch, interval_us=100_000)
        ground.link.close()
        console.loads_parameters(board.port, watch)
        describes_itself(board.port, watch)
        asyncio.run(companion.fly(board.port, watch))
        connect.flies(connect.Ground(board.port), watch)
        print(f"  {time.monotonic() - start:.0f} s; the board ran at {board.speed()}")


if __name__ == "__main__":
    main()
