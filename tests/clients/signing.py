"""pymavlink's own signing against the vehicle's, in both directions.

A key is set up, then: who has it is obeyed, and reads what the vehicle signs; who has none or another, who repeats what
was sent, whose clock is behind, changes nothing; and nothing old passes a restart.
"""

import pathlib
import sys
import tempfile
import time

from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mavlink

from served import Served, Stopwatch, expect

KEY, OTHER_KEY = bytes(range(1, 33)), bytes(range(2, 34))
PER_SECOND = 100_000
# of an answer that must come, s; on a busy computer the emulated board is slower than time
PATIENCE_S = 3.0


def timestamp():
    """Of now: 10 us since 2015."""
    return int((time.time() - 1420070400) * PER_SECOND)


class Ground:
    """A ground station that signs with a key, or with none."""

    def __init__(self, port, key=None, link_id=0, stamp=None):
        self.link = mavutil.mavlink_connection(f"tcp:127.0.0.1:{port}", source_system=255, source_component=190)
        self.sent, write = [], self.link.write
        self.link.write = lambda bytes_: (self.sent.append(bytes(bytes_)), write(bytes_))
        self.repeat = write
        if key is not None:
            self.sign(key, link_id, stamp)

    def sign(self, key, link_id=0, stamp=None):
        stamp = timestamp() if stamp is None else stamp
        self.link.setup_signing(key, sign_outgoing=True, initial_timestamp=stamp, link_id=link_id)

    def beat(self):
        self.link.mav.heartbeat_send(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0)

    def read(self, seconds, kind=None, so=lambda message: True):
        """The first that is so; what the link takes for wrongly signed does not come."""
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            message = self.link.recv_match(type=kind, blocking=True, timeout=0.05)
            if message is not None and so(message):
                return message
        return None

    def forget_answers(self):
        """Those to what was sent before, by whomever."""
        while self.read(0.2, "COMMAND_ACK"):
            pass

    def obeyed(self, patience_s=0.5):
        """Is its command answered, its parameter set? A harmless command, so that it can be tried often."""
        self.link.mav.command_long_send(1, 1, mavlink.MAV_CMD_REQUEST_MESSAGE, 0, 300, 0, 0, 0, 0, 0, 0)
        return self.read(patience_s, "COMMAND_ACK", lambda ack: ack.command == 512) is not None

    def obeyed_soon(self):
        """The first frame may only set the vehicle's clock; after a restart it may take a few seconds."""
        return any(self.obeyed() for _ in range(16))


def set_up(owner, watch):
    """A key, from nothing; whoever has none is not heard from then on."""
    expect(owner.obeyed_soon(), "without a key everybody is obeyed")
    owner.link.mav.setup_signing_send(1, 1, list(KEY), timestamp())
    expect(owner.read(5, "STATUSTEXT", lambda text: text.text.startswith("key stored")), "the key is stored")
    watch.lap("SETUP_SIGNING")


def unsigned_is_refused(ground, watch):
    ground.forget_answers()
    expect(not ground.obeyed(), "unsigned is refused")
    ground.link.mav.command_long_send(1, 1, mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0, 1, 0, 0, 0, 0, 0, 0)
    ground.link.mav.param_set_send(1, 1, b"PILOT_TILT_DEG", 20.0, mavlink.MAV_PARAM_TYPE_REAL32)
    expect(ground.read(1, ["COMMAND_ACK", "PARAM_VALUE"]) is None, "neither armed nor set")
    watch.lap("unsigned: refused")


def only_the_owner_is_obeyed(owner, port, watch):
    """The owner, who hears all answers, has the key; others come to the port. What the owner sent last."""
    owner.sign(KEY)
    expect(owner.obeyed_soon(), "signed is obeyed")
    signed = owner.read(2, "HEARTBEAT")
    expect(signed is not None and signed.get_signed(), "what the vehicle says is signed, and the key fits")
    watch.lap("signed with the key: obeyed, and the vehicle's signatures are right")
    replayed = owner.sent[-1]
    owner.forget_answers()
    owner.repeat(replayed)
    expect(owner.read(0.5, "COMMAND_ACK") is None, "a replay is refused")
    another = Ground(port)
    another.repeat(replayed)
    expect(owner.read(0.5, "COMMAND_ACK") is None, "over another connection, too")
    watch.lap("replayed: refused")
    thief = Ground(port, OTHER_KEY, link_id=1)
    for _ in range(3):
        thief.obeyed(0.3)
    expect(owner.read(0.5, "COMMAND_ACK") is None, "another key is refused")
    expect(thief.link.mav.signing.badsig_count > 0, "and cannot read what the vehicle signs as its own")
    watch.lap("signed with another key: refused")
    late = Ground(port, KEY, link_id=2, stamp=timestamp() - 3600 * PER_SECOND)
    late.obeyed(0.1)
    expect(owner.read(0.5, "COMMAND_ACK") is None, "a clock an hour behind is refused")
    watch.lap("clock behind: refused")
    expect(owner.obeyed(PATIENCE_S), "the owner is still obeyed")
    return replayed


def main():
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "key"
        with Served(sys.argv[1], "--signing", str(file)) as served:
            watch = Stopwatch()
            owner = Ground(served.port)
            set_up(owner, watch)
            unsigned_is_refused(owner, watch)
            owner.link.mav.setup_signing_send(1, 1, list(OTHER_KEY), timestamp())
            expect(owner.read(0.5, "STATUSTEXT", lambda text: "key" in text.text) is None, "no other key, unsigned")
            replayed = only_the_owner_is_obeyed(owner, served.port, watch)
        with Served(sys.argv[1], "--signing", str(file)) as served:
            silent, owner = Ground(served.port), Ground(served.port, KEY)
            silent.repeat(replayed)
            expect(owner.read(0.5, "COMMAND_ACK") is None, "nothing old passes a restart")
            start = time.monotonic()
            expect(owner.obeyed_soon(), "the owner does")
            watch.lap(f"after a restart: replay refused, owner obeyed after {time.monotonic() - start:.1f} s")


if __name__ == "__main__":
    main()
