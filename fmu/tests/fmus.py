"""FMUs by name of variable, and the loop of plant and controller, on FMPy's own calls."""

import functools
import math
import pathlib
import shutil
import tempfile

import fmpy
import numpy as np

CONTROL_STEP_S = 0.0025
RELEASE_S = 2.0

# what the rig does before it lets go, as `sil fly` has it: held at rest, armed at zero throttle, then hovering
ARMED_FROM_S, HOVERING_FROM_S = 1.8, 1.9

AXES = "xyz"
SAMPLES = [
    f"imu[{sample}].{what}"
    for sample in (1, 2, 3)
    for axis in AXES
    for what in (f"rate_body_{axis}_rad_s", f"specific_force_body_{axis}_m_s2")
]
COMMANDS = [f"motor{motor}_command" for motor in (1, 2, 3, 4)]
ANGLES = ["roll_rad", "pitch_rad", "yaw_rad"]


_unpacked = tempfile.TemporaryDirectory()


@functools.cache
def unpacked(path):
    """The folder of an FMU, unpacked once."""
    folder = pathlib.Path(_unpacked.name) / pathlib.Path(path).stem
    fmpy.extract(str(path), str(folder))
    return folder


class Fmu:
    """An instance of an FMU; with `edit` of a copy that it has changed. What the FMU logs is in `log`."""

    def __init__(self, path, interface="CoSimulation", start=None, start_s=0.0, edit=None, log=None):
        self.folder = unpacked(path)
        if edit is not None:
            copy = pathlib.Path(tempfile.mkdtemp(dir=_unpacked.name))
            self.folder = shutil.copytree(self.folder, copy / "fmu")
            edit(self.folder)
        self.description = fmpy.read_model_description(str(self.folder))
        self.variables = {variable.name: variable for variable in self.description.modelVariables}
        self.log = [] if log is None else log

        def keep(_environment, status, _category, text):
            self.log.append((status, text.decode()))

        self.instance = fmpy.instantiate_fmu(str(self.folder), self.description, interface, logger=keep)
        self.begin(start or {}, start_s)

    def begin(self, start, start_s=0.0):
        for name, value in start.items():
            self.set({name: value})
        self.instance.enterInitializationMode(startTime=start_s)
        self.instance.exitInitializationMode()

    def references(self, names):
        return [self.variables[name].valueReference for name in names]

    def set(self, values):
        for kind, put in [
            ("Float64", self.instance.setFloat64),
            ("UInt64", self.instance.setUInt64),
            ("Boolean", self.instance.setBoolean),
            ("String", self.instance.setString),
        ]:
            names = [name for name in values if self.variables[name].type == kind]
            if names:
                put(self.references(names), [values[name] for name in names])

    def get(self, names):
        return self.instance.getFloat64(self.references(names))

    def step(self, from_s, duration_s):
        self.instance.doStep(currentCommunicationPoint=from_s, communicationStepSize=duration_s)

    def close(self):
        self.instance.freeInstance()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def reference_at(waypoints, flown_s):
    """Roll and pitch requested, rad, of waypoints (time, roll, pitch in degrees)."""
    due = [waypoint for waypoint in waypoints if waypoint[0] <= flown_s]
    return [math.radians(degrees) for degrees in (due[-1][1:] if due else (0.0, 0.0))]


def script(waypoints, duration_s):
    """The same for `sil fly --script`."""
    steps = [f"[[step]]\nat_s = {at_s}\nroll_deg = {roll}\npitch_deg = {pitch}\n" for at_s, roll, pitch in waypoints]
    return f"duration_s = {duration_s}\n" + "".join(steps)


def closed_loop(plant, controller, waypoints, duration_s, hover, late=False, step_s=CONTROL_STEP_S):
    """Flies the plant with its IMU under the controller; angles and commands at each step after the release.

    The controller is stepped first and its commands are the plant's for the same step, as on the board; `late` is the
    order of a tool that steps both at once, so that the commands come a step later.
    """
    arm, throttle = False, 0.0
    angles, commands = [], []
    for step in range(round((RELEASE_S + duration_s) / step_s)):
        at_s = step * step_s
        hovers = at_s > HOVERING_FROM_S - 1e-9
        arm, throttle = at_s > ARMED_FROM_S - 1e-9 and not hovers, hover if hovers else 0.0
        # as `sil fly` counts it, in whole microseconds
        roll_rad, pitch_rad = reference_at(waypoints, (round(at_s * 1e6) - 2_000_000) / 1e6)
        inputs = dict(zip(SAMPLES, plant.get(SAMPLES)))
        inputs |= {"roll_reference_rad": roll_rad, "pitch_reference_rad": pitch_rad, "throttle": throttle, "arm": arm}
        controller.set(inputs)
        before = controller.get(COMMANDS)
        controller.step(at_s, step_s)
        given = before if late else controller.get(COMMANDS)
        if at_s > RELEASE_S - 1e-9:
            angles.append(plant.get(ANGLES))
            commands.append(given)
            plant.set(dict(zip(COMMANDS, given)))
        plant.step(at_s, step_s)
    return np.array(angles), np.array(commands)


def swing(base):
    """A second of commands at 400 Hz that turn the vehicle about both axes."""
    swing = 0.02 * np.sin(2.0 * np.pi * np.arange(0.0, 1.0, CONTROL_STEP_S))
    roll, pitch = np.array([-1.0, 1.0, 1.0, -1.0]), np.array([1.0, -1.0, 1.0, -1.0])
    return base + swing[:, None] * roll + 0.6 * swing[::-1, None] * pitch


def scales(description):
    """The continuous states by name, each with its typical size."""
    states = [variable.name[4:-1] for variable in description.modelVariables if variable.derivative]
    return {name: 1000.0 if "_speed_" in name else 1.0 for name in states}


def by_its_own(path, commands, start=None):
    """The plant by its own integrator: states over their typical size at each step's end."""
    with Fmu(path, start=start) as plant:
        sizes, rows = scales(plant.description), []
        for step, row in enumerate(commands):
            plant.set(dict(zip(COMMANDS, row)))
            plant.step(step * CONTROL_STEP_S, CONTROL_STEP_S)
            rows.append(plant.get(list(sizes)))
    return np.array(rows) / list(sizes.values())


def by_cvode(path, commands, start=None):
    """The same by FMPy's CVode, to 1e-9 of the states."""
    folder = str(unpacked(path))
    sizes = scales(fmpy.read_model_description(folder))
    rows = np.vstack([commands, commands[-1:]])
    types = [("time", float)] + [(command, float) for command in COMMANDS]
    signals = np.array([(step * CONTROL_STEP_S, *row) for step, row in enumerate(rows)], dtype=types)
    result = fmpy.simulate_fmu(
        folder,
        fmi_type="ModelExchange",
        stop_time=len(commands) * CONTROL_STEP_S,
        output_interval=CONTROL_STEP_S,
        relative_tolerance=1e-9,
        input=signals,
        start_values=start or {},
        output=list(sizes),
        record_events=False,
    )
    return np.array([[row[name] / size for name, size in sizes.items()] for row in result])[1:]


def apart(own, foreign):
    """By how much two motions differ at most, of the largest that a state becomes, or of its typical size."""
    return (np.abs(own - foreign).max(axis=0) / np.maximum(np.abs(own).max(axis=0), 1.0)).max()
