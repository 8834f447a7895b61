"""Another program's simulator is flown: PX4's convention between simulator and autopilot.

`px4_simulator.py` has the vehicle, which is none of this project's. As its owner would, a ground station tells the
board what it weighs and lifts, starts it anew and arms it; a pilot who sees the vehicle holds its height by the
throttle and has it lean 10 degrees to each side. Then the simulator goes away in flight, and comes back.
"""

import json
import pathlib
import sys
import tempfile
import time

from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mavlink

from px4_simulator import MASS_KG, Simulator
from served import Served, Stopwatch, expect

# of the Iris; lift is a constant times the square of 100 to 1100 rad/s
OWN = {"VEHICLE": 1, "VEH_MASS_G": round(1000 * MASS_KG), "VEH_ARM_MM": 247, "VEH_IXX_E5": 2913, "VEH_IYY_E5": 2913,
       "VEH_IZZ_E5": 5523, "VEH_TQ_LIFT_UM": 60000, "VEH_LIFT_MIN_MN": 58, "VEH_LIFT_MAX_MN": 7066, "VEH_LAG_E4": 200,
       "HOVER_PERMILLE": 703, "ROTOR_DRAG_PM_S": 200}
HEIGHT_M = 3.0
# of full stick, 30 degrees
TEN_DEG = 333
# held for a second, of the vehicle's true attitude, degrees: a gyro's bias, an arm that is longer to the side than
# ahead, and an accelerometer that feels the drag are in it
ERROR_MAX_DEG = 0.5
# of the vehicle's idea of the vertical, at any time that its motors turned, degrees
TILT_ERROR_MAX_DEG = 1.0


class Ground:
    """A ground station and the pilot at it."""

    def __init__(self, port, simulator):
        self.link = mavutil.mavlink_connection(f"tcp:127.0.0.1:{port}", source_system=255)
        self.simulator, self.texts, self.beat, self.throttle = simulator, [], None, 0
        self.is_ready, self.sent, self.sticks = False, 0.0, (0, 0)

    def pass_time(self, seconds, so=lambda message: False):
        """Sticks, and what the vehicle says; true as soon as `so` holds of a message."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if time.monotonic() - self.sent > 0.04:
                self.sent = time.monotonic()
                self.link.mav.heartbeat_send(6, 8, 0, 0, 0)
                self.link.mav.manual_control_send(1, *self.sticks, self.throttle, 0, 0)
            message = self.link.recv_match(blocking=True, timeout=0.01)
            if message is None:
                continue
            kind = message.get_type()
            if kind == "STATUSTEXT":
                self.texts.append(message.text)
            elif kind == "HEARTBEAT":
                self.beat = message
            elif kind == "SYS_STATUS":
                healthy = message.onboard_control_sensors_health & mavlink.MAV_SYS_STATUS_PREARM_CHECK
                self.is_ready = bool(healthy)
            if so(message):
                return True
        return False

    def now_s(self):
        return 1e-6 * self.simulator.time_us

    def command(self, number, parameter):
        self.link.mav.command_long_send(1, 1, number, 0, parameter, 0, 0, 0, 0, 0, 0)
        answered = []

        def is_answer(message):
            if message.get_type() == "COMMAND_ACK" and message.command == number:
                answered.append(message.result)
            return bool(answered)
        self.pass_time(3, is_answer)
        return answered == [0]

    def own(self):
        """Tells the board whose numbers are flown, once the sensors' rate is found, with which it starts."""
        expect(self.pass_time(10, lambda _: self.simulator.samples > 50), f"in lock-step: {self.simulator.samples}")
        for name, value in OWN.items():
            self.link.mav.param_set_send(1, 1, name.encode(), value, mavlink.MAV_PARAM_TYPE_REAL32)

            def is_taken(message, name=name, value=value):
                return message.get_type() == "PARAM_VALUE" and message.param_id == name and message.param_value == value
            expect(self.pass_time(3, is_taken), f"{name} {value} is taken: {self.texts}")
        expect(self.command(mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1), "started anew")
        self.is_ready = False

    def arm(self):
        self.throttle, self.sticks = 0, (0, 0)
        self.pass_time(0.2)
        expect(self.pass_time(20, lambda _: self.is_ready), f"ready for arming: {self.texts}")
        expect(self.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1), f"armed: {self.texts}")
        self.pass_time(0.5)
        expect(self.simulator.armed, "the simulator hears it")

    def hold(self, seconds, height_m=HEIGHT_M, sticks=(0, 0)):
        """Flies on, at a height by eye; the largest deviation of the true angles from the sticks' in the last second,
        degrees. By the simulator's time."""
        self.sticks, worst, end = sticks, 0.0, self.now_s() + seconds
        wanted = (10 * sticks[1] / TEN_DEG, -10 * sticks[0] / TEN_DEG)
        while self.now_s() < end and not self.simulator.ends:
            vehicle = self.simulator.vehicle
            below_m, sinks_m_s = height_m + vehicle.position[2], vehicle.velocity[2]
            climb_m_s = max(-0.7, min(1.0, below_m))
            self.throttle = round(max(100, min(950, 703 + 180 * (climb_m_s + sinks_m_s))))
            self.pass_time(0.02)
            if end - self.now_s() < 1.0:
                worst = max(worst, *(abs(angle - want) for angle, want in zip(vehicle.angles_deg(), wanted)))
        return worst

    def land(self):
        end = time.monotonic() + 20
        while self.simulator.vehicle.position[2] < -0.02 and time.monotonic() < end:
            self.hold(0.1, height_m=-0.5)
        self.throttle = 0
        self.pass_time(0.3)
        expect(self.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0), "disarmed")
        self.pass_time(0.3)
        expect(not self.simulator.armed and not any(self.simulator.controls), "nothing turns any more")


def flies(ground, watch):
    ground.arm()
    watch.lap("ready, armed")
    ground.hold(4)
    height_m = -ground.simulator.vehicle.position[2]
    expect(abs(height_m - HEIGHT_M) < 0.5, f"it hovers: {height_m} m")
    level = ground.hold(1.5)
    found = [ground.hold(2.5, sticks=sticks) for sticks in
             [(0, TEN_DEG), (0, -TEN_DEG), (-TEN_DEG, 0), (TEN_DEG, 0)]]
    expect(max(level, *found) < ERROR_MAX_DEG, f"off by {level} level, {found} degrees at 10")
    watch.lap(f"hovers level within {level:.2f} degrees; 10 degrees right, left, up, down within "
              f"{', '.join(f'{worst:.2f}' for worst in found)}")


def main():
    sil = sys.argv[1]
    for controller, rate_hz in [("pid", 250), ("mpc", 400)]:
        print(f"  {controller}, {rate_hz} sensors per second")
        watch, simulator = Stopwatch(), Simulator(rate_hz, speed=2.0)
        simulator.start()
        with tempfile.TemporaryDirectory() as folder:
            figures = pathlib.Path(folder) / "figures.json"
            arguments = ["--simulator", f"tcp:127.0.0.1:{simulator.port}", "--controller", controller]
            with Served(sil, *arguments, "--json", str(figures), seconds=60) as served:
                ground = Ground(served.port, simulator)
                ground.own()
                flies(ground, watch)
                ground.land()
                watch.lap("landed, disarmed")
                expect(not simulator.mistakes, f"{simulator.mistakes[:5]}")
                if controller == "pid":
                    goes_away(ground, served, watch)
                # the rest as fast as it goes
                begin, samples, ground.simulator.speed = time.monotonic(), ground.simulator.samples, 0
                served.wait()
                rate = (ground.simulator.samples - samples) / (time.monotonic() - begin)
            found = json.loads(figures.read_text())["simulator"]
            expect(found["loop_hz"] == 1e6 / ground.simulator.period_us, f"{found}")
            expect(0 < found["tilt_error_max_deg"] < TILT_ERROR_MAX_DEG and found["truths"] > 1000, f"{found}")
            watch.lap(f"{rate:.0f} samples answered per second where nothing holds them up; {found}")


def goes_away(ground, served, watch):
    """In flight the simulator ends: said, disarmed; and once it is there again, a new start."""
    simulator = ground.simulator
    ground.arm()
    ground.hold(2)
    simulator.stop()

    def is_disarmed(message):
        return message.get_type() == "HEARTBEAT" and not message.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED
    ground.texts.clear()
    expect(ground.pass_time(3, is_disarmed), "without its IMU it disarms")
    expect(any("IMU" in text for text in ground.texts), f"and says why: {ground.texts}")
    expect(any("has left" in line or "is lost" in line for line in served.lines), f"{served.lines}")
    watch.lap(f"simulator gone: {ground.texts}")
    ground.simulator, ground.is_ready = Simulator(400, port=simulator.port, speed=2.0), False
    ground.simulator.start()
    ground.arm()
    ground.hold(1.5)
    ground.land()
    expect(not ground.simulator.mistakes, f"{ground.simulator.mistakes[:5]}")
    watch.lap("another simulator, at 400 sensors per second: flown and landed")


if __name__ == "__main__":
    main()
