"""A quadrotor's simulator for PX4, as a third program would be: it knows PX4's convention and nothing of this project.

It waits at a TCP port for an autopilot, and once that has said HEARTBEAT sends HIL_SENSOR, HIL_GPS and, if asked,
HIL_STATE_QUATERNION, encoded by pymavlink. From the first HIL_ACTUATOR_CONTROLS on it makes its next step only when the
last sample was answered, as Gazebo classic and jMAVSim do.

The vehicle is a rigid body with four rotors: Newton's and Euler's equations in north-east-down and forward-right-down
axes, each rotor's speed a first-order lag behind 100 + 1000 controls[i] rad/s, its thrust a constant times the speed's
square. Masses, arms and constants are those of PX4's Iris (Gazebo classic's `iris.sdf.jinja`).
"""

import math
import random
import select
import socket
import threading
import time

from pymavlink.dialects.v20 import common as mavlink

from attitude import roll_pitch_rad

GRAVITY_M_S2 = 9.80665
MASS_KG = 1.535
INERTIA_KG_M2 = (0.029125, 0.029125, 0.055225)
# thrust over the speed's square, N s^2; torque over thrust, m
THRUST_N_S2, TORQUE_M = 5.84e-6, 0.06
ROTOR_LAG_S = 0.02
# air over speed, N s/m; over rate, N m s
DRAG_NS_M, DAMPING_NMS = 0.3, 0.002
# forward and right of the centre, m; 1 where the propeller turns clockwise, seen from above. PX4's order for a quad-x:
# front right and rear left counter-clockwise, front left and rear right clockwise
ROTORS = ((0.13, 0.21, -1), (-0.13, -0.21, -1), (0.13, -0.21, 1), (-0.13, 0.21, 1))
SUBSTEP_S = 0.001
# of one sample: m/s^2, rad/s
ACCEL_NOISE, GYRO_NOISE = 0.05, 0.005
GYRO_BIAS = (0.01, -0.015, 0.005)
ALL_SENSORS = 0x1FFF
HOME_DEG = (47.397742, 8.545594)
METRES_PER_DEG = 111_194.9


class Quadrotor:
    """Position, velocity, attitude and rate, and what the rotors do."""

    def __init__(self):
        self.position, self.velocity = [0.0] * 3, [0.0] * 3
        self.q, self.rate = [1.0, 0.0, 0.0, 0.0], [0.0] * 3
        self.speeds, self.felt = [0.0] * 4, [0.0, 0.0, -GRAVITY_M_S2]

    def axes(self):
        """Rows of the matrix from body to world."""
        w, x, y, z = self.q
        return ((1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
                (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
                (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)))

    def angles_deg(self):
        return tuple(math.degrees(angle) for angle in roll_pitch_rad(self.q))

    def advance(self, controls, armed, duration_s):
        thrusts = []
        for rotor in range(4):
            wanted = 100 + 1000 * controls[rotor] if armed else 0.0
            self.speeds[rotor] += (wanted - self.speeds[rotor]) * (1 - math.exp(-duration_s / ROTOR_LAG_S))
            thrusts.append(THRUST_N_S2 * self.speeds[rotor] ** 2)
        rows = self.axes()
        lift = sum(thrusts)
        # thrust along the body's up, air against the motion; both in the world's axes
        force = [-lift * rows[axis][2] - DRAG_NS_M * self.velocity[axis] for axis in range(3)]
        acceleration = [force[0] / MASS_KG, force[1] / MASS_KG, force[2] / MASS_KG + GRAVITY_M_S2]
        if self.position[2] >= 0.0 and acceleration[2] >= 0.0:
            # the ground holds it as it stands
            self.position[2], self.velocity, self.rate, acceleration = 0.0, [0.0] * 3, [0.0] * 3, [0.0] * 3
        else:
            self.turn(thrusts, duration_s)
        for axis in range(3):
            self.velocity[axis] += acceleration[axis] * duration_s
            self.position[axis] += self.velocity[axis] * duration_s
        self.position[2] = min(self.position[2], 0.0)
        free = [acceleration[0], acceleration[1], acceleration[2] - GRAVITY_M_S2]
        self.felt = [sum(rows[world][body] * free[world] for world in range(3)) for body in range(3)]

    def turn(self, thrusts, duration_s):
        """Torque is arm times thrust, which points up; the air turns the body against each propeller."""
        torque = [0.0] * 3
        for (forward, right, spin), thrust in zip(ROTORS, thrusts):
            torque[0] -= right * thrust
            torque[1] += forward * thrust
            torque[2] -= spin * TORQUE_M * thrust
        p, q, r = self.rate
        ixx, iyy, izz = INERTIA_KG_M2
        self.rate = [p + duration_s * (torque[0] - DAMPING_NMS * p - (izz - iyy) * q * r) / ixx,
                     q + duration_s * (torque[1] - DAMPING_NMS * q - (ixx - izz) * r * p) / iyy,
                     r + duration_s * (torque[2] - DAMPING_NMS * r - (iyy - ixx) * p * q) / izz]
        p, q, r = self.rate
        w, x, y, z = self.q
        half = 0.5 * duration_s
        turned = [w - half * (x * p + y * q + z * r), x + half * (w * p + y * r - z * q),
                  y + half * (w * q - x * r + z * p), z + half * (w * r + x * q - y * p)]
        norm = math.sqrt(sum(part * part for part in turned))
        self.q = [part / norm for part in turned]


class Simulator(threading.Thread):
    """The program around it: one autopilot, in lock-step, at `speed` times real time (0: as fast as it answers)."""

    def __init__(self, rate_hz, port=0, speed=1.0, seed=1):
        super().__init__(daemon=True)
        self.period_us, self.speed = round(1e6 / rate_hz), speed
        self.random = random.Random(seed)
        self.listener = socket.create_server(("127.0.0.1", port))
        self.port = self.listener.getsockname()[1]
        self.vehicle, self.controls, self.armed = Quadrotor(), [0.0] * 16, False
        self.time_us, self.samples, self.answers, self.asked_truth_us = 0, 0, 0, None
        self.mistakes, self.heartbeats, self.ends = [], [], False

    def run(self):
        self.stream, _ = self.listener.accept()
        self.listener.close()
        self.stream.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.parser = mavlink.MAVLink(None)
        self.parser.robust_parsing = True
        self.encoder = mavlink.MAVLink(self, srcSystem=1, srcComponent=200)
        try:
            while not self.heartbeats and not self.ends:
                self.hear(0.1)
            begin = time.monotonic()
            while not self.ends:
                self.step()
                ahead_s = self.time_us * 1e-6 / self.speed - (time.monotonic() - begin) if self.speed else 0.0
                if ahead_s > 0:
                    time.sleep(ahead_s)
        except OSError as error:
            self.ends = True
            self.mistakes.append(f"the autopilot went away: {error}")
        self.stream.close()

    def stop(self):
        """As a program that ends: the connection is closed."""
        self.ends = True
        self.join()

    def write(self, frame):
        """What the encoder has."""
        self.stream.sendall(frame)

    def hear(self, patience_s):
        if not select.select([self.stream], [], [], patience_s)[0]:
            return
        data = self.stream.recv(4096)
        if not data:
            raise OSError("closed")
        for message in self.parser.parse_buffer(data) or []:
            kind = message.get_type()
            if kind == "HIL_ACTUATOR_CONTROLS":
                self.answers += 1
                self.controls, self.armed = list(message.controls), bool(message.mode & 128)
                if message.time_usec != self.time_us or not message.flags & 1:
                    self.mistakes.append(f"an answer to {message.time_usec} at {self.time_us}, flags {message.flags}")
                if not all(0.0 <= control <= 1.0 for control in self.controls):
                    self.mistakes.append(f"controls {self.controls}")
            elif kind == "HEARTBEAT":
                self.heartbeats.append((self.time_us, message.base_mode))
            elif kind == "COMMAND_LONG" and message.command == 511 and message.param1 == 115:
                self.asked_truth_us = int(message.param2)

    def step(self):
        left_us = self.period_us
        while left_us > 0:
            substep_us = min(left_us, 1e6 * SUBSTEP_S)
            self.vehicle.advance(self.controls, self.armed, 1e-6 * substep_us)
            left_us -= substep_us
        self.time_us += self.period_us
        if self.asked_truth_us and self.time_us % (self.period_us * max(1, self.asked_truth_us // self.period_us)) == 0:
            self.send_truth()
        if self.time_us % 100_000 < self.period_us:
            self.send_gps()
        expected = self.answers + 1
        self.send_sensors()
        self.samples += 1
        until = time.monotonic() + 5
        while self.answers < expected and not self.ends:
            if time.monotonic() > until:
                self.mistakes.append(f"no answer to the sample of {self.time_us} us within 5 s")
                self.ends = True
            self.hear(0.1)

    def send_sensors(self):
        noisy = self.random.gauss
        accel = [noisy(value, ACCEL_NOISE) for value in self.vehicle.felt]
        gyro = [noisy(value + bias, GYRO_NOISE) for value, bias in zip(self.vehicle.rate, GYRO_BIAS)]
        height_m = -self.vehicle.position[2]
        pressure_hpa = 1013.25 * (1 - 2.25577e-5 * height_m) ** 5.25588
        self.encoder.hil_sensor_send(self.time_us, *accel, *gyro, 0.215, 0.01, 0.43, pressure_hpa, 0.0, height_m, 20.0,
                                     ALL_SENSORS)

    def place(self):
        north, east, _ = self.vehicle.position
        lon_deg = HOME_DEG[1] + east / (METRES_PER_DEG * math.cos(math.radians(HOME_DEG[0])))
        return round(1e7 * (HOME_DEG[0] + north / METRES_PER_DEG)), round(1e7 * lon_deg)

    def send_gps(self):
        cm_s = [round(100 * speed) for speed in self.vehicle.velocity]
        ground = round(math.hypot(*cm_s[:2]))
        self.encoder.hil_gps_send(self.time_us, 3, *self.place(), round(-1000 * self.vehicle.position[2]), 100, 100,
                                  ground, *cm_s, 0, 10)

    def send_truth(self):
        cm_s = [round(100 * speed) for speed in self.vehicle.velocity]
        self.encoder.hil_state_quaternion_send(self.time_us, self.vehicle.q, *self.vehicle.rate, *self.place(),
                                               round(-1000 * self.vehicle.position[2]), *cm_s, 0, 0, 0, 0, 0)
