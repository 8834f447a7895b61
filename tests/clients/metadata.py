"""The parameters' descriptions by MAVLink FTP, with pymavlink's own mavftp and with MAVSDK.

From COMPONENT_METADATA to the general file, from there to the parameters' one, as QGroundControl goes; then what it
says is held against the list of parameters: each is described, each value lies in its range and is the default. Once
over TCP, once over a link that loses a fifth of the datagrams, doubles and swaps others.
"""

import asyncio
import json
import pathlib
import sys
import tempfile
import time

from mavsdk import System
from mavsdk.component_metadata import MetadataType
from pymavlink import mavftp, mavutil
from pymavlink.dialects.v20 import common as mavlink

from bad_link import SEED, BadLink
from served import COMPONENT_METADATA, Served, Stopwatch, component_metadata, expect

PARAMETERS = 1
# The client asks three times to open a file and gives up; a fifth lost each way, that is one time in twenty. Whoever
# sits before it asks once more.
TRIES_OVER_BAD_LINK = 5
# of parameter.schema.json
KEYS = {"name", "type", "group", "shortDesc", "units", "default", "min", "max", "decimalPlaces", "increment", "values",
        "rebootRequired"}

FROM_THE_NEXT_START = {"LOOP_RATE_HZ", "PULSES", "PWM_RATE_HZ", "HIL", "TELEM1_KBAUD", "ESC_CALIBRATION"}


def crc32(data):
    """MAVLink's, with nothing inverted at start and end."""
    crc = 0
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xEDB88320 if crc & 1 else 0)
    return crc


class Reader:
    """Reads files of the vehicle."""

    def __init__(self, link, folder, tries):
        self.link, self.folder, self.tries = link, pathlib.Path(folder), tries
        self.ftp = mavftp.MAVFTP(link, 1, 1)

    def read(self, uri):
        expect(uri.startswith("mftp://"), f"an address of this protocol: {uri}")
        path = self.folder / "read"
        for _ in range(self.tries):
            self.ftp.cmd_get([uri.removeprefix("mftp://"), str(path)])
            result = self.ftp.process_ftp_reply("OpenFileRO", timeout=60)
            if result.error_code == mavftp.FtpError.Success:
                return path.read_bytes()
        expect(False, f"{uri} is read: {result.error_code!r}")

    def crc(self, uri):
        """As the vehicle says: the client itself only prints it."""
        name = uri.removeprefix("mftp://").encode()
        # number 700, no session, CalcFileCRC32
        payload = bytearray([*(700).to_bytes(2, "little"), 0, 14, len(name), 0, 0, 0, 0, 0, 0, 0]) + name
        self.link.mav.file_transfer_protocol_send(0, 1, 1, payload.ljust(251, b"\0"))
        answer = self.link.recv_match(type="FILE_TRANSFER_PROTOCOL", blocking=True, timeout=2)
        return int.from_bytes(bytes(answer.payload[12:16]), "little")


def until(send, receive, words):
    """Sends every second until there is an answer."""
    end, sent = time.monotonic() + 20, 0.0
    while time.monotonic() < end:
        if time.monotonic() - sent > 1.0:
            sent = time.monotonic()
            send()
        found = receive()
        if found is not None:
            return found
    expect(False, words)


def values(link):
    """All parameters' values by name."""
    found = {}
    count = None

    def ask():
        missing = [] if count is None else [index for index in range(count) if index not in found][:10]
        if not missing:
            link.mav.param_request_list_send(1, 1)
        for index in missing:
            link.mav.param_request_read_send(1, 1, b"", index)

    def take():
        nonlocal count
        value = link.recv_match(type="PARAM_VALUE", blocking=True, timeout=0.1)
        if value is not None:
            count = value.param_count
            found[value.param_index] = (value.param_id, value.param_value)
        return True if count is not None and len(found) == count else None
    until(ask, take, "all parameters")
    return dict(found.values())


def describe(link, folder, watch, tries=1):
    """Reads the files, checks them, and returns the parameters' descriptions by name, and the file."""
    request = (1, 1, mavlink.MAV_CMD_REQUEST_MESSAGE, 0, COMPONENT_METADATA, 0, 0, 0, 0, 0, 0)
    kind = f"UNKNOWN_{COMPONENT_METADATA}"
    answer = until(lambda: link.mav.command_long_send(*request),
                   lambda: link.recv_match(type=kind, blocking=True, timeout=0.1), "COMPONENT_METADATA")
    crc, uri = component_metadata(answer)
    watch.lap(f"COMPONENT_METADATA: {uri}")
    reader = Reader(link, folder, tries)
    general = reader.read(uri)
    expect(crc32(general) == crc, "the general file's CRC")
    described = json.loads(general)
    expect(described["version"] >= 1, "a version")
    of_parameters = [one for one in described["metadataTypes"] if one["type"] == PARAMETERS]
    expect(len(of_parameters) == 1, f"one file of parameters: {described}")
    file = reader.read(of_parameters[0]["uri"])
    expect(crc32(file) == of_parameters[0]["fileCrc"], "the parameters' file's CRC")
    watch.lap(f"{len(general)} and {len(file)} bytes read")
    parameters = json.loads(file)
    expect(set(parameters) == {"version", "parameters"} and parameters["version"] >= 3, "its head")
    by_name = {one["name"]: one for one in parameters["parameters"]}
    expect(len(by_name) == len(parameters["parameters"]), "no name twice")
    return by_name, of_parameters[0], reader


def held_against_list(by_name, found):
    """The vehicle is as it came: every value is its default, but for the vehicle, which it knows."""
    expect(set(by_name) == set(found), f"the same names: {set(by_name) ^ set(found)}")
    for name, value in found.items():
        one = by_name[name]
        expect(set(one) <= KEYS, f"known keys: {one}")
        expect(one["type"] == "Float" and one["shortDesc"] and one["group"], f"described: {one}")
        expect(one["min"] <= value <= one["max"], f"{name} {value} in its range: {one}")
        expect(one["default"] == value or name == "VEHICLE", f"{name} {value} is the default: {one}")
        expect(one["rebootRequired"] is (name in FROM_THE_NEXT_START), f"says when it counts: {one}")
        if "values" in one:
            expect(value in [allowed["value"] for allowed in one["values"]], f"{name} {value} is one of {one}")


def refuses_outside(link, by_name):
    """What the description says of the ends is what the vehicle takes; in the end all is as it was."""
    for name in ["BATT_LOW_TIMER", "IMU1_ROLL_CDEG", "VEH_MASS_G"]:
        one = by_name[name]
        for value, is_taken in [(one["max"], True), (one["max"] + 1, False), (one["min"], True),
                                (one["min"] - 1, False), (one["default"], True)]:
            link.mav.param_set_send(1, 1, name.encode(), value, mavlink.MAV_PARAM_TYPE_REAL32)
            answer = link.recv_match(type="PARAM_VALUE", blocking=True, timeout=2)
            expect(answer is not None and (answer.param_value == value) == is_taken, f"{name} {value}: {is_taken}")


async def by_mavsdk(port):
    """The parameters' file as MAVSDK's own plugin finds it."""
    drone = System()
    await drone.connect(system_address=f"tcpout://127.0.0.1:{port}")
    async for state in drone.core.connection_state():
        if state.is_connected:
            break
    await drone.component_metadata.request_autopilot_component()

    async def arrived():
        async for update in drone.component_metadata.metadata_available():
            if update.type == MetadataType.PARAMETER:
                return update.json_metadata
    return json.loads(await asyncio.wait_for(arrived(), 30))


def main():
    sil, watch = sys.argv[1], Stopwatch()
    with tempfile.TemporaryDirectory() as folder:
        with Served(sil) as served:
            link = mavutil.mavlink_connection(f"tcp:127.0.0.1:{served.port}", source_system=255)
            by_name, file, reader = describe(link, folder, watch)
            expect(reader.crc(file["uri"]) == file["fileCrc"], "CalcFileCRC32 says the same")
            held_against_list(by_name, values(link))
            watch.lap(f"{len(by_name)} parameters as described")
            refuses_outside(link, by_name)
            watch.lap("nothing outside a described range is taken")
            link.close()
            found = asyncio.run(by_mavsdk(served.port))
            expect({one["name"]: one for one in found["parameters"]} == by_name, "MAVSDK reads the same")
            watch.lap("MAVSDK reads the same")
        bad = BadLink()
        bad.start()
        ground_port, client_port = bad.ports()
        with Served(sil, udp=str(ground_port)):
            link = mavutil.mavlink_connection(f"udpout:127.0.0.1:{client_port}", source_system=255)
            link.mav.heartbeat_send(6, 8, 0, 0, 0)
            again, *_ = describe(link, folder, watch, TRIES_OVER_BAD_LINK)
            expect(again == by_name, "the same over a bad link")
            expect(bad.lost > 10, "the link was bad")
            watch.lap(f"{bad.lost} of {bad.lost + bad.passed} datagrams lost, seed {SEED}")


if __name__ == "__main__":
    main()
