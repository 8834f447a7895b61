"""pymavlink asks what QGroundControl asks when it connects, message by message, and times each answer.

The order is that of QGroundControl's `InitialConnectStateMachine.cc`, with what older versions asked besides.
"""

import sys
import time

from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mavlink

from served import COMPONENT_METADATA, Served, Stopwatch, component_metadata, expect

# of an answer, s; a ground station repeats its question after 1 s or more
PATIENCE_S = 1.0
UNSUPPORTED, DENIED, ACCEPTED, REJECTED = 3, 2, 0, 1


class Ground:
    """A ground station's side of the link."""

    def __init__(self, port, patience_s=3):
        self.link = mavutil.mavlink_connection(f"tcp:127.0.0.1:{port}", source_system=255, source_component=190)
        self.heartbeat = self.link.wait_heartbeat(timeout=patience_s)
        expect(self.heartbeat is not None, f"a heartbeat within {patience_s} s")
        self.beat()

    def beat(self):
        self.link.mav.heartbeat_send(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0)

    def wait(self, kind, so=lambda message: True, patience_s=PATIENCE_S):
        until = time.monotonic() + patience_s
        while time.monotonic() < until:
            message = self.link.recv_match(type=kind, blocking=True, timeout=0.05)
            if message is not None and so(message):
                return message
        return None

    def command(self, number, *parameters, by_int=False):
        """Sends a command and returns its result; there must be exactly one."""
        given = [*parameters, *([0] * (7 - len(parameters)))]
        if by_int:
            whole = [int(given[4]), int(given[5])]
            self.link.mav.command_int_send(1, 1, 0, number, 0, 0, *given[:4], *whole, given[6])
        else:
            self.link.mav.command_long_send(1, 1, number, 0, *given)
        ack = self.wait("COMMAND_ACK", lambda ack: ack.command == number)
        expect(ack is not None, f"an answer to command {number}")
        return ack.result

    def request(self, message_id, kind, parameter=0.0):
        expect(self.command(mavlink.MAV_CMD_REQUEST_MESSAGE, message_id, parameter) == ACCEPTED, f"{kind} granted")
        message = self.wait(kind)
        expect(message is not None, f"{kind} sent")
        return message


def connect(ground, watch):
    heartbeat = ground.heartbeat
    expect((heartbeat.type, heartbeat.autopilot) == (2, 0), "a generic quadrotor")
    expect(heartbeat.base_mode & mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED, "a custom mode")
    watch.lap(f"HEARTBEAT, mode {heartbeat.custom_mode:#x}")
    version = ground.request(mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION, "AUTOPILOT_VERSION")
    expect(version.capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_MAVLINK2, "MAVLink 2")
    expect(version.capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_FTP, "files")
    expect(not version.capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_INT, "no missions promised")
    watch.lap(f"AUTOPILOT_VERSION, software {version.flight_sw_version:#010x}")
    # newer dialects have dropped the message, whose bytes are then all that is seen of it
    expect(ground.command(mavlink.MAV_CMD_REQUEST_MESSAGE, 300) == ACCEPTED, "PROTOCOL_VERSION granted")
    expect(ground.wait(["PROTOCOL_VERSION", "UNKNOWN_300"]) is not None, "PROTOCOL_VERSION sent")
    watch.lap("PROTOCOL_VERSION")
    modes = {}
    mode = ground.request(435, "AVAILABLE_MODES", 1)
    while True:
        modes[mode.custom_mode] = mode.mode_name
        if mode.mode_index == mode.number_modes:
            break
        mode = ground.request(435, "AVAILABLE_MODES", mode.mode_index + 1)
    expect(heartbeat.custom_mode in modes, "the mode of the heartbeat is listed")
    watch.lap(f"AVAILABLE_MODES: {', '.join(modes.values())}")
    current = ground.request(436, "CURRENT_MODE")
    expect(current.custom_mode == heartbeat.custom_mode, "the same mode in both")
    watch.lap("CURRENT_MODE")
    _, uri = component_metadata(ground.request(COMPONENT_METADATA, f"UNKNOWN_{COMPONENT_METADATA}"))
    expect(uri == "mftp:///general.json", f"where the parameters are described: {uri}")
    watch.lap(f"COMPONENT_METADATA: {uri}")
    parameters = {}
    ground.link.mav.param_request_list_send(1, 1)
    while True:
        value = ground.wait("PARAM_VALUE", patience_s=2)
        expect(value is not None, f"more parameters than {len(parameters)}")
        parameters[value.param_id] = value.param_value
        if len(parameters) == value.param_count:
            break
    watch.lap(f"{len(parameters)} parameters")
    for kind, name in [(0, "mission"), (1, "fence"), (2, "rally points")]:
        ground.link.mav.mission_request_list_send(1, 1, kind)
        count = ground.wait("MISSION_COUNT", lambda count: count.mission_type == kind)
        expect(count is not None and count.count == 0 and count.target_system == 255, f"{name}: none")
        watch.lap(f"MISSION_COUNT: no {name}")
    ground.link.mav.timesync_send(0, 12345)
    answer = ground.wait("TIMESYNC", lambda message: message.ts1 == 12345)
    expect(answer is not None and answer.tc1 > 0, "TIMESYNC answered")
    watch.lap("TIMESYNC")
    return parameters


def answers(ground, watch):
    """One answer to each command, the right one, however it comes."""
    for by_int in [False, True]:
        for number, parameters, result in [
            (mavlink.MAV_CMD_NAV_TAKEOFF, [], UNSUPPORTED),
            (31000, [], UNSUPPORTED),
            (65000, [], UNSUPPORTED),
            (mavlink.MAV_CMD_REQUEST_MESSAGE, [mavlink.MAVLINK_MSG_ID_HOME_POSITION], DENIED),
            (mavlink.MAV_CMD_DO_SET_MODE, [1, 4], DENIED),
            (mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, [mavlink.MAVLINK_MSG_ID_HEARTBEAT, -1], DENIED),
            (mavlink.MAV_CMD_DO_MOTOR_TEST, [9, 0, 5, 1], REJECTED),
            (mavlink.MAV_CMD_DO_SET_MODE, [1, 7], ACCEPTED),
        ]:
            found = ground.command(number, *parameters, by_int=by_int)
            expect(found == result, f"command {number}: {found}, not {result}")
            second = ground.wait("COMMAND_ACK", lambda ack: ack.command == number, 0.1)
            expect(second is None, f"command {number} is answered once")
    watch.lap("one answer to each of 16 commands")


def intervals(ground, watch, interval_us=20_000):
    imu = mavlink.MAVLINK_MSG_ID_HIGHRES_IMU
    expect(ground.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, imu, interval_us) == ACCEPTED, "HIGHRES_IMU")
    # by the vehicle's own clock: an emulated board that lags behind this one catches up
    until, stamps_us = time.monotonic() + 2, []
    while time.monotonic() < until:
        message = ground.link.recv_match(type="HIGHRES_IMU", blocking=True, timeout=0.1)
        stamps_us += [message.time_usec] if message else []
    count = len(stamps_us)
    expect(count > 5, f"HIGHRES_IMU, not {count} in 2 s")
    wanted = 1 + (stamps_us[-1] - stamps_us[0]) / interval_us
    expect(0.8 * wanted <= count <= 1.1 * wanted, f"{wanted:.0f} HIGHRES_IMU in that time, not {count}")
    message = ground.request(244, "MESSAGE_INTERVAL", imu)
    expect((message.message_id, message.interval_us) == (imu, interval_us), "MESSAGE_INTERVAL says so")
    expect(ground.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, imu, -1) == ACCEPTED, "HIGHRES_IMU off")
    for name in ["ATTITUDE_QUATERNION", "ATTITUDE_TARGET", "BATTERY_STATUS", "VIBRATION", "EXTENDED_SYS_STATE",
                 "SYSTEM_TIME", "SYS_STATUS", "SERVO_OUTPUT_RAW", "RC_CHANNELS", "HIGHRES_IMU"]:
        ground.request(getattr(mavlink, f"MAVLINK_MSG_ID_{name}"), name)
    watch.lap(f"intervals: {count} HIGHRES_IMU in 2 s; ten messages on request")


def flies(ground, watch):
    """Refused with a reason while the throttle is up, armed without, stopped by force."""
    def stick(throttle):
        ground.link.mav.manual_control_send(1, 0, 0, throttle, 0, 0)
    # the gyro is calibrated by now
    stick(500)
    expect(ground.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1) == REJECTED, "no arming with throttle")
    text = ground.wait("STATUSTEXT", lambda text: text.text.startswith("refused"))
    expect(text is not None and "throttle" in text.text, "the reason in words")
    stick(0)
    expect(ground.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1) == ACCEPTED, "armed")
    armed = ground.wait("HEARTBEAT", lambda beat: beat.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED, 1.5)
    expect(armed is not None, "the heartbeat says so")
    expect(ground.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0, 21196) == ACCEPTED, "stopped by force")
    status = ground.request(mavlink.MAVLINK_MSG_ID_HEARTBEAT, "HEARTBEAT")
    expect(not status.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED, "and is disarmed")
    watch.lap(f"arming refused (\"{text.text}\"), armed, stopped by force")


def main():
    with Served(sys.argv[1], "--rig", "gimbal") as served:
        watch = Stopwatch()
        ground = Ground(served.port)
        connect(ground, watch)
        answers(ground, watch)
        intervals(ground, watch)
        flies(ground, watch)


if __name__ == "__main__":
    main()
