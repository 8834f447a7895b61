"""A link that loses a fifth of the datagrams, doubles and swaps others: the parameter list still completes.

The ground asks for the list, then by index for what did not come, as ground stations do.
"""

import sys
import time

from pymavlink import mavutil

from bad_link import SEED, BadLink
from served import Served, Stopwatch, expect


def parameters(link, patience_s=30):
    """All of them: name and value by index."""
    found, count = {}, None
    until, last_news = time.monotonic() + patience_s, 0.0
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
    expect(count is not None and len(found) == count, f"{len(found)} of {count} parameters in {patience_s} s")
    return found


def main():
    bad = BadLink()
    bad.start()
    ground_port, client_port = bad.ports()
    with Served(sys.argv[1], udp=str(ground_port)):
        watch = Stopwatch()
        link = mavutil.mavlink_connection(f"udpout:127.0.0.1:{client_port}", source_system=255)
        found = parameters(link)
        expect(bad.lost > 10, "the link was bad")
        watch.lap(f"{len(found)} parameters, {bad.lost} of {bad.lost + bad.passed} datagrams lost, seed {SEED}")


if __name__ == "__main__":
    main()
