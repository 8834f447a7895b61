"""The emulated board over USB: its log downloaded by pymavlink, by MAVProxy and over a link that loses a fifth of the
frames, doubles and swaps others, as the list of parameters is; then a key for signed frames, which is taken there alone
and keeps everybody else on TELEM1 from the vehicle.
"""

import pathlib
import sys
import tempfile
import time

from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mavlink
from pyulog import ULog

import board
import connect
import logs
import lossy
import signing
from bad_link import SEED, AsDatagrams, BadLink
from served import Board, Stopwatch, expect

# a download over the bad link, on a busy computer
PATIENCE_S = 300


def log_something(ground):
    """A short log: armed, idling."""
    board.arm(ground)
    ground.wait("HEARTBEAT", patience_s=1)
    expect(ground.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0) == connect.ACCEPTED, "disarmed")
    board.stay(ground, 5)


def downloads(served, folder, watch):
    ground = connect.Ground(served.usb_port, board.FOUND_S)
    board.owner(ground, watch)
    log_something(ground)
    entries = logs.listed(ground.link)
    expect(list(entries) == [0], f"one log: {entries}")
    log = logs.downloaded(ground.link, entries[0], PATIENCE_S)
    path = pathlib.Path(folder) / "downloaded.ulg"
    path.write_bytes(log)
    read = ULog(str(path))
    topics = {one.name for one in read.data_list}
    # the cascade flies: nothing of the MPC
    expect(topics == logs.TOPICS - {"mpc_status"}, f"pyulog opens it: {topics}")
    expect(not read.dropouts and not read.file_corruption, "nothing is missing, nothing damaged")
    ground.link.close()
    watch.lap(f"{len(log)} bytes of log by pymavlink, {len(topics)} topics in it")
    found, words = logs.by_mavproxy(folder, f"tcp:127.0.0.1:{served.usb_port}")
    expect(found == log, "MAVProxy downloads the same")
    watch.lap(f"MAVProxy: {words}")
    return log, entries[0]


def over_a_bad_link(served, log, entry, watch):
    bad = BadLink()
    bad.start()
    ground_port, client_port = bad.ports()
    line = AsDatagrams(served.usb_port, ground_port)
    line.start()
    link = mavutil.mavlink_connection(f"udpout:127.0.0.1:{client_port}", source_system=255)
    found = lossy.parameters(link, PATIENCE_S)
    watch.lap(f"{len(found)} parameters, {bad.lost} of {bad.lost + bad.passed} frames lost, seed {SEED}")
    expect(logs.downloaded(link, entry, PATIENCE_S) == log, "the same log")
    expect(bad.lost > 100, "the link was bad")
    watch.lap(f"the log, {bad.lost} of {bad.lost + bad.passed} frames lost")
    line.end()


def signs(served, watch):
    """The key comes over USB, whose owner hears all answers; TELEM1 may be anybody's radio."""
    owner, radio = signing.Ground(served.usb_port), signing.Ground(served.port)
    expect(radio.obeyed_soon(), "without a key TELEM1 is obeyed")
    radio.link.mav.setup_signing_send(1, 1, list(signing.OTHER_KEY), signing.timestamp())
    refused = radio.read(signing.PATIENCE_S, "STATUSTEXT", lambda text: text.text.startswith("signing not changed"))
    expect(refused is not None, "no key over TELEM1")
    watch.lap(f"SETUP_SIGNING over TELEM1: \"{refused.text}\"")
    signing.set_up(owner, watch)
    signing.unsigned_is_refused(owner, watch)
    signing.unsigned_is_refused(radio, watch)
    replayed = signing.only_the_owner_is_obeyed(owner, served.port, watch)
    owner.link.mav.command_long_send(1, 1, mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 0, 1, 0, 0, 0, 0, 0, 0)
    time.sleep(1.0)
    owner, radio = signing.Ground(served.usb_port, signing.KEY), signing.Ground(served.port)
    expect(owner.read(board.FOUND_S, "HEARTBEAT"), "the board is back")
    radio.repeat(replayed)
    expect(owner.read(1, "COMMAND_ACK") is None, "nothing old passes a restart")
    expect(owner.obeyed_soon(), "the owner does")
    watch.lap("after a restart: replay refused, owner obeyed")
    # the way out without the key: whoever has the cable
    cable = signing.Ground(served.usb_port)
    cable.link.mav.setup_signing_send(1, 1, [0] * 32, 0)
    expect(radio.obeyed_soon(), "a key of zeros over USB ends it: TELEM1 is obeyed unsigned")
    watch.lap("a key of zeros over USB ends it")


def main():
    start = time.monotonic()
    with tempfile.TemporaryDirectory() as folder, Board(*sys.argv[1:3]) as served:
        watch = Stopwatch()
        log, entry = downloads(served, folder, watch)
        over_a_bad_link(served, log, entry, watch)
        signs(served, watch)
        print(f"  {time.monotonic() - start:.0f} s; the board ran at {served.speed()}")


if __name__ == "__main__":
    main()
