"""A link that loses a fifth of the datagrams, doubles and swaps others, and how a serial line becomes one."""

import random
import socket
import threading

LOST, DOUBLED, SWAPPED = 0.2, 0.1, 0.1
SEED = 1


# of a frame of MAVLink 2: its start, and its length without payload and signature
START, AROUND, SIGNATURE = 0xFD, 12, 13


class AsDatagrams(threading.Thread):
    """A serial line at a TCP port as a link of datagrams, each a frame: what an adapter with a network does."""

    def __init__(self, port, ground_port):
        super().__init__(daemon=True)
        self.line = socket.create_connection(("127.0.0.1", port))
        self.line.settimeout(0.005)
        self.link, self.to = socket.socket(socket.AF_INET, socket.SOCK_DGRAM), ("127.0.0.1", ground_port)
        self.link.setblocking(False)
        self.held, self.ended = b"", threading.Event()

    def run(self):
        while not self.ended.is_set():
            try:
                self.held += self.line.recv(4096)
            except TimeoutError:
                pass
            for frame in self.frames():
                self.link.sendto(frame, self.to)
            try:
                while True:
                    self.line.sendall(self.link.recv(4096))
            except BlockingIOError:
                pass
        self.line.close()

    def frames(self):
        """All whole frames; what lies between them is nobody's."""
        while (start := self.held.find(START)) >= 0 and len(self.held) >= start + AROUND:
            signature = SIGNATURE if self.held[start + 2] & 1 else 0
            end = start + AROUND + self.held[start + 1] + signature
            if len(self.held) < end:
                return
            yield self.held[start:end]
            self.held = self.held[end:]

    def end(self):
        self.ended.set()
        self.join()


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
