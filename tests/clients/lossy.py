"""A link that loses a fifth of the datagrams, doubles and swaps others: the parameter list still completes.

The ground asks for the list, then by index for what did not come, as ground stations do.
"""

import random
import socket
import sys
import threading
import time

from pymavlink import mavutil

from served import Served, Stopwatch, expect

LOST, DOUBLED, SWAPPED = 0.2, 0.1, 0.1
SEED = 1


class BadLink(threading.Thread):
    """Between the vehicle, which sends to `ground_port`, and a client of `client_port`."""

    def __init__(self):
        super().__init__(daemon=True)
        self.random = random.Random(SEED)
        self.to_vehicle, self.to_client = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2)]
        for end in [self.to_vehicle, self.to_client]:
            end.bind(("127.0.0.1", 0))
            end.settimeout(0.01)
        self.vehicle, self.client, self.kept = None, None, {}
        self.passed = self.lost = 0

    def run(self):
        while True:
            for end in [self.to_vehicle, self.to_client]:
                try:
                    datagram, sender = end.recvfrom(4096)
                except TimeoutError:
                    continue
                if end is self.to_vehicle:
                    self.vehicle = sender
                    self.spoil(self.to_client, self.client, datagram)
                else:
                    self.client = sender
                    self.spoil(self.to_vehicle, self.vehicle, datagram)

    def spoil(self, end, to, datagram):
        if to is None:
            return
        draw = self.random.random()
        if draw < LOST:
            self.lost += 1
            return
        if draw < LOST + SWAPPED and end not in self.kept:
            self.kept[end] = datagram
            return
        self.passed += 1
        for one in [datagram, *([datagram] if draw > 1 - DOUBLED else []), *([self.kept.pop(end)] if end in self.kept
                                                                            else [])]:
            end.sendto(one, to)


def main():
    bad = BadLink()
    bad.start()
    ground_port, client_port = [end.getsockname()[1] for end in [bad.to_vehicle, bad.to_client]]
    with Served(sys.argv[1], udp=str(ground_port)):
        watch = Stopwatch()
        link = mavutil.mavlink_connection(f"udpout:127.0.0.1:{client_port}", source_system=255)
        found, count = {}, None
        until, last_news = time.monotonic() + 30, 0.0
        while time.monotonic() < until and (count is None or len(found) < count):
            if time.monotonic() - last_news > 0.5:
                link.mav.heartbeat_send(6, 8, 0, 0, 0)
                if count is None:
                    link.mav.param_request_list_send(1, 1)
                else:
                    for index in [index for index in range(count) if index not in found][:10]:
                        link.mav.param_request_read_send(1, 1, b"", index)
                last_news = time.monotonic()
            value = link.recv_match(type="PARAM_VALUE", blocking=True, timeout=0.1)
            if value is not None:
                count, last_news = value.param_count, time.monotonic()
                found[value.param_index] = (value.param_id, value.param_value)
        expect(count is not None and len(found) == count, f"{len(found)} of {count} parameters in 30 s")
        expect(bad.lost > 10, "the link was bad")
        watch.lap(f"{count} parameters, {bad.lost} of {bad.lost + bad.passed} datagrams lost, seed {SEED}")


main()
