"""Flight logs: written, listed, downloaded, opened.

pymavlink flies the vehicle and downloads the log piece by piece; MAVProxy downloads it over a link that loses a fifth
of the datagrams; pyulog opens it, and its values are those that came as telemetry at the same times. A log of `sil fly`
has the values of the same flight's CSV.
"""

import csv
import math
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy
from pymavlink import mavutil
from pyulog import ULog
from pyulog.px4 import PX4ULog

from attitude import roll_pitch_rad
from bad_link import BadLink
from served import Served, Stopwatch, expect, mavproxy

PIECE = 90
# requests that wait at the vehicle
WAITING_MAX = 20
TOPICS = {"sensor_combined", "vehicle_angular_velocity", "vehicle_attitude", "actuator_motors",
          "vehicle_attitude_setpoint", "vehicle_rates_setpoint", "battery_status", "mpc_status", "vehicle_status"}


def fly(link):
    """Arms, rolls to either side, disarms; the ATTITUDE and SERVO_OUTPUT_RAW that came meanwhile."""
    heard = {"ATTITUDE": [], "SERVO_OUTPUT_RAW": []}

    def pass_time(seconds, throttle, roll, until=lambda message: False):
        end, sent = time.monotonic() + seconds, 0.0
        while time.monotonic() < end:
            if time.monotonic() - sent > 0.05:
                sent = time.monotonic()
                link.mav.heartbeat_send(6, 8, 0, 0, 0)
                link.mav.manual_control_send(1, 0, roll, throttle, 0, 0)
            message = link.recv_match(blocking=True, timeout=0.02)
            if message is not None and message.get_type() in heard:
                heard[message.get_type()].append(message)
            if message is not None and until(message):
                return True
        return False

    def is_ready(message):
        prearm = mavutil.mavlink.MAV_SYS_STATUS_PREARM_CHECK
        return message.get_type() == "SYS_STATUS" and message.onboard_control_sensors_health & prearm

    def arm(parameter):
        number = mavutil.mavlink.MAV_CMD_COMPONENT_ARM_DISARM
        link.mav.command_long_send(1, 1, number, 0, parameter, 0, 0, 0, 0, 0, 0)
        return pass_time(5, 0, 0, lambda message: message.get_type() == "COMMAND_ACK" and message.result == 0)
    expect(pass_time(20, 0, 0, is_ready), "ready for arming")
    expect(arm(1), "armed")
    # it counts once it was low after arming
    for throttle, roll in [(0, 0), (500, 200), (500, -300)]:
        pass_time(0.4, throttle, roll)
    expect(arm(0), "disarmed")
    pass_time(1.0, 0, 0)
    return heard


def listed(link):
    """The list, asked for until it is whole."""
    entries, asked, end = {}, 0.0, time.monotonic() + 20
    while time.monotonic() < end:
        if time.monotonic() - asked > 1.0:
            asked = time.monotonic()
            link.mav.log_request_list_send(1, 1, 0, 0xFFFF)
        entry = link.recv_match(type="LOG_ENTRY", blocking=True, timeout=0.1)
        if entry is not None:
            entries[entry.id] = entry
            if len(entries) >= entry.num_logs:
                return entries
    expect(False, f"the list is whole: {entries}")


def gaps(missing):
    """Runs of pieces without a break: first and last."""
    runs = []
    for piece in missing:
        if runs and runs[-1][1] + 1 == piece:
            runs[-1][1] = piece
        else:
            runs.append([piece, piece])
    return runs


def downloaded(link, entry, patience_s=60):
    """A log in chunks of 512 pieces, as QGroundControl asks for it, and then its gaps, as many as may wait."""
    log, have = bytearray(entry.size), set()
    pieces = math.ceil(entry.size / PIECE)
    asked, asked_chunk, end = 0.0, None, time.monotonic() + patience_s
    while len(have) < pieces and time.monotonic() < end:
        chunk = min(at for at in range(pieces) if at not in have) // 512 * 512
        if time.monotonic() - asked > 1.0 or chunk != asked_chunk:
            asked, asked_chunk = time.monotonic(), chunk
            missing = [at for at in range(chunk, min(chunk + 512, pieces)) if at not in have]
            for first, last in gaps(missing)[:WAITING_MAX]:
                link.mav.log_request_data_send(1, 1, entry.id, first * PIECE, (last + 1 - first) * PIECE)
        piece = link.recv_match(type="LOG_DATA", blocking=True, timeout=0.1)
        if piece is not None and piece.id == entry.id and piece.count:
            asked = time.monotonic()
            log[piece.ofs:piece.ofs + piece.count] = bytes(piece.data[:piece.count])
            have.add(piece.ofs // PIECE)
    expect(len(have) == pieces, f"{len(have)} of {pieces} pieces")
    link.mav.log_request_end_send(1, 1)
    return bytes(log)


def by_mavproxy(folder, master):
    """What MAVProxy makes of the first log."""
    path = pathlib.Path(folder) / "mavproxy.ulg"
    found = mavproxy(master, "log", folder, "--cmd", f"log download 0 {path}",
                     until="Finished downloading", patience_s=200)
    return path.read_bytes(), found.split("ulg ")[-1]


def held_against_telemetry(path, heard):
    """Every topic is there, and what came over the link stands in the log at the same time, to the bit."""
    log = ULog(str(path))
    data = {one.name: one.data for one in log.data_list}
    expect(set(data) == TOPICS, f"topics: {sorted(data)}")
    expect(not log.dropouts and not log.file_corruption, "nothing is missing, nothing damaged")
    expect(log.initial_parameters["CONTROLLER"] == 1 and len(log.initial_parameters) > 70, "the parameters")
    steps = numpy.diff(data["actuator_motors"]["timestamp"])
    expect((steps == 2500).all(), f"every step: {set(steps)}")
    expect(0.1 < data["battery_status"]["voltage_v"].min(), "the battery's voltage")
    attitude, velocity, motors = (data[name] for name in ["vehicle_attitude", "vehicle_angular_velocity",
                                                          "actuator_motors"])
    row_of = {int(stamp): row for row, stamp in enumerate(attitude["timestamp"])}
    compared = 0
    for message in heard["ATTITUDE"]:
        row = row_of.get(message.time_boot_ms * 1000)
        if row is None:
            continue
        compared += 1
        for place, name in enumerate(["rollspeed", "pitchspeed", "yawspeed"]):
            expect(velocity[f"xyz[{place}]"][row] == numpy.float32(getattr(message, name)), f"{name} of {message}")
        # the vehicle's arc tangent is one of 32 bit numbers
        roll, pitch = roll_pitch_rad(float(attitude[f"q[{place}]"][row]) for place in range(4))
        expect(abs(roll - message.roll) < 1e-5 and abs(pitch - message.pitch) < 1e-5, f"{roll} {pitch} {message}")
    expect(compared > 20, f"{compared} attitudes")
    expect(max(abs(message.roll) for message in heard["ATTITUDE"]) > 0.05, "it moved")
    pulses = 0
    for message in heard["SERVO_OUTPUT_RAW"]:
        row = row_of.get(message.time_usec)
        if row is None:
            continue
        for motor in range(4):
            # 1000 to 2000 us, cut to whole ones
            pulse_us = 1000 + 1000 * float(motors[f"control[{motor}]"][row])
            expect(abs(pulse_us - getattr(message, f"servo{motor + 1}_raw")) <= 1, f"motor {motor + 1} of {message}")
        pulses += 1
    expect(pulses > 8, f"{pulses} pulses")
    reads_as_flight_review(log, data)
    return compared, pulses


def reads_as_flight_review(log, data):
    """What the page of Flight Review takes first: angles from rotations, changes of the mode, the battery."""
    px4 = PX4ULog(log)
    px4.add_roll_pitch_yaw()
    setpoint = log.get_dataset("vehicle_attitude_setpoint").data
    for angle in ["roll", "pitch"]:
        expect(numpy.allclose(setpoint[f"{angle}_d"], setpoint[f"{angle}_body"], atol=1e-5), f"{angle} set-point")
    modes = [int(mode) for _, mode in log.get_dataset("vehicle_status").list_value_changes("nav_state")]
    expect(modes == [15], f"stabilise all along: {modes}")
    status = data["vehicle_status"]
    expect(status["arming_state"][0] == 2 and status["arming_state"][-1] == 1, "armed, then disarmed")
    expect(status["is_vtol"].max() == 0 and status["failsafe"].max() == 0, "no VTOL, no failsafe")
    expect({"voltage_v", "current_a", "discharged_mah", "remaining"} <= set(data["battery_status"]), "the battery")


def held_against_csv(sil, folder):
    """The same flight as CSV and as ULog, column by column."""
    paths = [pathlib.Path(folder) / name for name in ["flown.csv", "flown.ulg"]]
    for path in paths:
        subprocess.run([sil, "fly", "--controller", "pid", "--rig", "free", "--log", str(path)], check=True,
                       stdout=subprocess.DEVNULL)
    lines = [line for line in paths[0].read_text().splitlines() if not line.startswith("#")]
    rows = list(csv.DictReader(lines))
    data = {one.name: one.data for one in ULog(str(paths[1])).data_list}
    columns = {"p_rad_s": ("vehicle_angular_velocity", "xyz[0]"), "q_rad_s": ("vehicle_angular_velocity", "xyz[1]"),
               "r_rad_s": ("sensor_combined", "gyro_rad[2]"), "az_m_s2": ("sensor_combined", "accelerometer_m_s2[2]"),
               "roll_ref_rad": ("vehicle_attitude_setpoint", "roll_body"),
               "pitch_ref_rad": ("vehicle_attitude_setpoint", "pitch_body"),
               **{f"motor{motor + 1}": ("actuator_motors", f"control[{motor}]") for motor in range(4)}}
    for name, (topic, field) in columns.items():
        expected = numpy.array([float(row[name]) for row in rows], dtype=numpy.float32)
        expect(numpy.array_equal(data[topic][field], expected), f"{name} is {topic}.{field}")
    stamps = numpy.array([round(float(row["time_s"]) * 1e6) for row in rows], dtype=numpy.uint64)
    expect(numpy.array_equal(data["actuator_motors"]["timestamp"], stamps), "times")
    return len(rows), len(columns)


def main():
    sil, watch = sys.argv[1], Stopwatch()
    with tempfile.TemporaryDirectory() as folder:
        logs = pathlib.Path(folder) / "logs"
        bad = BadLink()
        ground_port, client_port = bad.ports()
        arguments = ["--logs", str(logs), "--controller", "mpc", "--speed", "2"]
        with Served(sil, *arguments, udp=str(ground_port), seconds=1200) as served:
            link = mavutil.mavlink_connection(f"tcp:127.0.0.1:{served.port}", source_system=255)
            heard = fly(link)
            watch.lap("flown")
            entries = listed(link)
            expect(list(entries) == [0] and entries[0].num_logs == 1, f"one log: {entries}")
            log = downloaded(link, entries[0])
            files = list(logs.iterdir())
            expect(len(files) == 1 and files[0].read_bytes() == log, "what was downloaded is what was written")
            watch.lap(f"{len(log)} bytes downloaded by pymavlink")
            attitudes, pulses = held_against_telemetry(files[0], heard)
            watch.lap(f"pyulog: {len(TOPICS)} topics, {attitudes} attitudes and {pulses} pulses as the link had them")
            link.close()
            bad.start()
            found, words = by_mavproxy(folder, f"udpout:127.0.0.1:{client_port}")
            expect(found == log, "what MAVProxy downloaded is what was written")
            watch.lap(f"MAVProxy, {bad.lost} of {bad.lost + bad.passed} datagrams lost: {words}")
            link = mavutil.mavlink_connection(f"tcp:127.0.0.1:{served.port}", source_system=255)
            link.mav.log_erase_send(1, 1)
            expect(listed(link)[0].num_logs == 0 and not list(logs.iterdir()), "all are erased")
            watch.lap("erased")
        rows, columns = held_against_csv(sil, folder)
        watch.lap(f"sil fly: {rows} rows of {columns} columns as in the CSV")


if __name__ == "__main__":
    main()
