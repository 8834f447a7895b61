"""A link that loses a fifth of the datagrams, doubles and swaps others."""

import random
import socket
import threading

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

    def ports(self):
        """Where the vehicle sends to, and where a client does."""
        return [end.getsockname()[1] for end in [self.to_vehicle, self.to_client]]
