"""The FMUs as a co-simulation tool has them: validated, simulated and closed to a loop by FMPy, held against `sil`.

`cargo xtask fmu --check` runs this. FMUS is the folder of the FMUs, MODELS that of the models that they are made of,
SIL the command line.
"""

import csv
import ctypes
import json
import os
import pathlib
import subprocess

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

from fmus import ANGLES, COMMANDS, CONTROL_STEP_S, SAMPLES, Fmu, closed_loop, script

FMUS, MODELS, SIL = (pathlib.Path(os.environ[name]) for name in ("FMUS", "MODELS", "SIL"))
NAMES = [f"{level}_{rig}" for rig in ("gimbal", "free") for level in ("f450", "generic", "box")]

# of the test sequence's kind, with both axes at once
WAYPOINTS = [(0.5, 20.0, 0.0), (1.5, 0.0, -15.0), (2.5, -10.0, 10.0), (3.5, 0.0, 0.0)]
FLOWN_S = 4.5


def base_command(name):
    [line] = [line for line in model(name).read_text().splitlines() if line.startswith("base_command")]
    return float(line.split("=")[1].split("#")[0])


def model(name):
    return MODELS / f"{name.replace('_', '-')}.toml"


@pytest.mark.parametrize("content", ["plant", "plant_imu", "controller"])
@pytest.mark.parametrize("name", NAMES)
def test_fmpy_has_no_finding(content, name):
    assert validate_fmu(str(FMUS / f"{content}_{name}.fmu")) == []


def test_each_unit_is_that_of_the_name():
    endings = {"_rad_s": "rad/s", "_rad": "rad", "_m_s2": "m/s2", "_m_s": "m/s", "_m": "m", "_n": "N", "_nm": "N.m"}
    endings |= {"_v": "V", "_a": "A", "_s": "s"}
    seen = 0
    for path in sorted(FMUS.glob("*.fmu")):
        for variable in fmpy.read_model_description(str(path)).modelVariables:
            assert variable.description or variable.name == "time"
            of_name = max((ending for ending in endings if variable.name.endswith(ending)), key=len, default=None)
            if of_name and not variable.name.startswith("der("):
                assert variable.unit == endings[of_name], variable.name
                seen += 1
    assert seen > 300


def fly(tmp_path, file, controller, seed):
    """`sil fly`: rows of its log as they are printed, and its figures."""
    (tmp_path / "script.toml").write_text(script(WAYPOINTS, FLOWN_S))
    subprocess.run(
        [SIL, "fly", "--quiet", "--model", file, "--controller", controller, "--script", "script.toml"]
        + ["--seed", str(seed), "--log", "log.csv", "--json", "figures.json"],
        cwd=tmp_path,
        check=True,
    )
    with (tmp_path / "log.csv").open() as log:
        rows = list(csv.DictReader(line for line in log if not line.startswith("#")))
    return rows, json.loads((tmp_path / "figures.json").read_text())["runs"][0]


def without_noise_of_the_logger(name, folder, effects=""):
    """A model whose logged angles are the true ones; what the controller gets stays noisy."""
    text = "".join(
        "attitude_rad = 0.0\n" if line.startswith("attitude_rad") else line
        for line in model(name).read_text().splitlines(keepends=True)
    )
    file = folder / "quiet-log.toml"
    file.write_text(text + effects)
    return file


def effort(commands, base):
    """Mean |command - base|, summed in the order of `sil`: another last bit of any command shows."""
    total = 0.0
    for row in commands:
        total += sum(abs(command - base) for command in row) / 4.0
    return total / len(commands)


EFFECTS = {
    "": ("", ""),
    "delay, lag and a weak motor": (
        "actuation_delay:delay_s=0.004;motor_lag:lag_s=0.01; weak_motor:motor=2,factor=0.9",
        '[[effect]]\nname = "actuation_delay"\ndelay_s = 0.004\n[[effect]]\nname = "motor_lag"\nlag_s = 0.01\n'
        '[[effect]]\nname = "weak_motor"\nmotor = 2\nfactor = 0.9\n',
    ),
}


@pytest.mark.parametrize(
    "name, controller, effects",
    [
        ("f450_gimbal", "pid", ""),
        ("f450_gimbal", "mpc", ""),
        ("f450_gimbal", "pid", "delay, lag and a weak motor"),
        ("f450_free", "pid", ""),
        ("generic_gimbal", "mpc", ""),
        ("box_free", "pid", ""),
    ],
)
def test_the_loop_of_two_fmus_is_sil_fly(tmp_path, name, controller, effects):
    """No tolerance: the same code, the same seed, the same instants. The log has six digits; the mean effort of all
    commands, of which each has all its digits, is equal to the bit."""
    short, tables = EFFECTS[effects]
    rows, figures = fly(tmp_path, without_noise_of_the_logger(name, tmp_path, tables), controller, 7)
    base = base_command(name)
    start = {"seed": 7, "released_at_s": 2.0, "effects": short}
    with (
        Fmu(FMUS / f"plant_imu_{name}.fmu", start=start) as plant,
        Fmu(FMUS / f"controller_{name}.fmu", start={"controller": controller}) as core,
    ):
        angles, commands = closed_loop(plant, core, WAYPOINTS, FLOWN_S, base)
    assert len(rows) == len(angles) == FLOWN_S * 400
    assert np.abs(angles[:, :2]).max() > np.radians(14.0)
    logged = np.array([[float(row[name]) for name in ANGLES] for row in rows])
    assert np.abs(logged - angles).max() <= 0.5e-6 + 1e-12
    logged = np.array([[float(row[f"motor{motor}"]) for motor in (1, 2, 3, 4)] for row in rows])
    assert np.abs(logged - commands).max() <= 0.5e-6 + 1e-12
    assert effort(commands, base) == figures["effort"]


def test_another_seed_is_another_flight(tmp_path):
    _, figures = fly(tmp_path, without_noise_of_the_logger("f450_gimbal", tmp_path), "pid", 7)
    with (
        Fmu(FMUS / "plant_imu_f450_gimbal.fmu", start={"seed": 8, "released_at_s": 2.0}) as plant,
        Fmu(FMUS / "controller_f450_gimbal.fmu") as core,
    ):
        _, commands = closed_loop(plant, core, WAYPOINTS, FLOWN_S, base_command("f450_gimbal"))
    assert effort(commands, base_command("f450_gimbal")) != figures["effort"]


def open_loop(name):
    """Commands at 400 Hz that swing the vehicle about both axes and back."""
    time_s = np.arange(0.0, 1.0, CONTROL_STEP_S)
    swing = 0.05 * np.sin(2.0 * np.pi * time_s)
    pattern = np.array([[-1.0, 1.0, 1.0, -1.0], [1.0, -1.0, 1.0, -1.0]])
    return time_s, base_command(name) + swing[:, None] * pattern[0] + 0.6 * swing[::-1, None] * pattern[1]


def in_steps(name, commands, start=None):
    """The plant by its own integrator, states at each step's end."""
    with Fmu(FMUS / f"plant_{name}.fmu", start=start) as plant:
        angles = []
        for step, row in enumerate(commands):
            plant.set(dict(zip(COMMANDS, row)))
            plant.step(step * CONTROL_STEP_S, CONTROL_STEP_S)
            angles.append(plant.get(ANGLES))
    return np.array(angles)


def by_cvode(name, commands, start=None):
    """The same by FMPy's CVode, to 1e-9 of the state."""
    rows = np.vstack([commands, commands[-1:]])
    types = [("time", float)] + [(command, float) for command in COMMANDS]
    signals = np.array([(step * CONTROL_STEP_S, *row) for step, row in enumerate(rows)], dtype=types)
    result = fmpy.simulate_fmu(
        str(FMUS / f"plant_{name}.fmu"),
        fmi_type="ModelExchange",
        stop_time=len(commands) * CONTROL_STEP_S,
        output_interval=CONTROL_STEP_S,
        relative_tolerance=1e-9,
        input=signals,
        start_values=start or {},
        output=ANGLES,
    )
    return np.array([[row[angle] for angle in ANGLES] for row in result])[1:]


@pytest.mark.parametrize(
    "name, effects",
    [(name, "") for name in NAMES]
    + [
        ("f450_gimbal", "actuation_delay:delay_s=0.006"),
        ("f450_gimbal", "motor_lag:lag_s=0.02"),
        ("f450_free", "actuation_delay:delay_s=0.0033; motor_lag:lag_s=0.02"),
        ("generic_gimbal", "step_disturbance:axis=roll,moment_nm=0.05,at_s=0.3012"),
    ],
)
def test_a_foreign_integrator_finds_the_plants_motion(name, effects):
    """Model exchange against co-simulation: another integrator on the same equations. The plant's Runge-Kutta takes
    steps of at most 0.5 ms and is accurate to some 1e-5 of the motion (sil-host/src/plant/integrate.rs), here of half
    a radian."""
    _, commands = open_loop(name)
    start = {"effects": effects} if effects else None
    own, foreign = in_steps(name, commands, start), by_cvode(name, commands, start)
    assert own.shape == foreign.shape
    assert 0.1 < np.abs(own).max() < 3.0
    assert np.abs(own - foreign).max() < 1e-5


def test_effects_change_the_motion():
    _, commands = open_loop("f450_gimbal")
    nominal = in_steps("f450_gimbal", commands)
    late = in_steps("f450_gimbal", commands, {"effects": "actuation_delay:delay_s=0.006"})
    assert np.abs(nominal - late).max() > 1e-3


def test_start_values_and_disturbances_act():
    with Fmu(FMUS / "plant_f450_gimbal.fmu", start={"roll_rad": 0.2, "disturbance_torque_body_y_nm": 0.01}) as plant:
        assert plant.get(["roll_rad"]) == [0.2]
        plant.step(0.0, 0.1)
        [roll_rad, pitch_rate] = plant.get(["roll_rad", "pitch_euler_rate_rad_s"])
        # by hand: level motors and a constant moment on body and ring, of which a tilt leaves the cosine
        assert abs(roll_rad - 0.2) < 1e-3
        expected = 0.01 * np.cos(0.2) / (0.0115118 * np.cos(0.2) ** 2 + 0.02 * np.sin(0.2) ** 2 + 0.0250533) * 0.1
        assert abs(pitch_rate / expected - 1.0) < 1e-3


def test_a_rotor_that_is_switched_off_never_turns_backwards():
    """Its stop is put right at an event of the foreign integration."""
    commands = np.zeros((400, 4))
    rows = np.array(
        [(0.0, *[0.0] * 4), (2.0, *[0.0] * 4)], dtype=[("time", float)] + [(command, float) for command in COMMANDS]
    )
    speeds = [f"motor{motor}_speed_rad_s" for motor in (1, 2, 3, 4)]
    result = fmpy.simulate_fmu(
        str(FMUS / "plant_f450_gimbal.fmu"), fmi_type="ModelExchange", stop_time=2.0, input=rows, output=speeds
    )
    assert min(result[speed].min() for speed in speeds) > -1e-3
    assert result[speeds[0]][0] > 100.0 > result[speeds[0]][-1]
    assert commands.shape == (400, 4)


def test_two_instances_do_not_meet():
    path = FMUS / "plant_f450_gimbal.fmu"
    _, commands = open_loop("f450_gimbal")
    with Fmu(path) as one, Fmu(path) as other:
        for step, row in enumerate(commands):
            one.set(dict(zip(COMMANDS, row)))
            one.step(step * CONTROL_STEP_S, CONTROL_STEP_S)
            other.step(step * CONTROL_STEP_S, CONTROL_STEP_S)
        assert abs(one.get(ANGLES)[0]) > 1e-3
        assert other.get(ANGLES) == [0.0, 0.0, 0.0]


def test_a_reset_forgets_everything():
    names = ANGLES + SAMPLES
    with Fmu(FMUS / "plant_imu_f450_free.fmu", start={"seed": 3}) as plant:
        def fly():
            plant.set({"motor1_command": 0.7})
            for step in range(20):
                plant.step(step * CONTROL_STEP_S, CONTROL_STEP_S)
            return plant.get(names)

        first = fly()
        plant.instance.reset()
        plant.begin({"seed": 3})
        assert fly() == first
        plant.instance.reset()
        plant.begin({"seed": 4})
        assert fly() != first


@pytest.mark.parametrize("content", ["plant_imu", "controller"])
def test_a_saved_state_is_taken_up_again(content):
    names = ANGLES + SAMPLES if content == "plant_imu" else COMMANDS + ["roll_estimate_rad"]
    start = {"controller": "mpc"} if content == "controller" else {"seed": 5}
    with Fmu(FMUS / f"{content}_f450_gimbal.fmu", start=start) as fmu:
        inputs = {"throttle": 0.5, "arm": True} if content == "controller" else {"motor2_command": 0.6}
        fmu.set(inputs)
        fmu.step(0.0, 1.0)
        saved = fmu.instance.getFMUState()
        def on():
            for step in range(40):
                fmu.step(1.0 + step * CONTROL_STEP_S, CONTROL_STEP_S)
            return fmu.get(names)

        first = on()
        fmu.instance.setFMUState(saved)
        assert on() == first
        fmu.instance.freeFMUState(saved)


def refused(work, fmu, told):
    """The call fails, and the log says why."""
    fmu.log.clear()
    with pytest.raises(FMICallException):
        work()
    assert len(fmu.log) == 1 and fmu.log[0][0] == 3, fmu.log
    assert told in fmu.log[0][1], fmu.log


@pytest.mark.parametrize(
    "content, wrong, told",
    [
        ("plant", {"effects": "wobble:x=1"}, 'wobble'),
        ("plant", {"effects": "motor_lag:lag_s=-1"}, "lag_s"),
        ("plant_imu", {"imu_rate_hz": 0}, "imu_rate_hz = 0: expected 1 to 8000"),
        ("controller", {"controller": "lqr"}, "lqr"),
        ("controller", {"controller": 'controller = "pid"\nrate_hz = 1'}, "1"),
        ("controller", {"imu_samples_per_step": 4}, "imu_samples_per_step = 4: expected 1 to 3"),
    ],
)
def test_a_wrong_parameter_is_refused_with_its_reason(content, wrong, told):
    with Fmu(FMUS / f"{content}_f450_gimbal.fmu") as fmu:
        fmu.instance.reset()
        fmu.set(wrong)
        fmu.instance.enterInitializationMode()
        refused(fmu.instance.exitInitializationMode, fmu, told)
        # and it can be mended
        fmu.instance.reset()
        fmu.begin({})


def test_calls_that_make_no_sense_are_refused_with_their_reason():
    with Fmu(FMUS / "plant_f450_gimbal.fmu") as fmu:
        instance = fmu.instance
        for work, told in [
            (lambda: fmu.step(0.0, -0.1), "forward"),
            (lambda: fmu.step(0.0, float("nan")), "forward"),
            (lambda: fmu.step(1.0, 0.1), "0 s have been reached"),
            (lambda: instance.getFloat64([9999]), "no variable with the value reference 9999"),
            (lambda: instance.getUInt64(fmu.references(["roll_rad"])), "Float64"),
            (lambda: instance.setFloat64(fmu.references(["roll_rad"]), [1.0]), "roll_rad: can't be set in step mode"),
            (lambda: instance.setFloat64(fmu.references(["disturbance_torque_body_x_nm"]), [float("nan")]), "NaN"),
            (lambda: instance.setString(fmu.references(["effects"]), ["spring"]), "can't be set in step mode"),
            (lambda: instance.getFloat32([1]), "no variable has this type"),
            (lambda: instance.enterInitializationMode(), "in step mode"),
            (lambda: instance.enterEventMode(), "in step mode"),
            (lambda: instance.enterConfigurationMode(), "structural parameters"),
            (lambda: instance.serializeFMUState(None), "saved states as bytes"),
            (lambda: instance.getDirectionalDerivative([1], [2], [1.0]), "partial derivatives"),
        ]:
            refused(work, fmu, told)
        fmu.set({"motor1_command": float("nan")})
        fmu.step(0.0, 0.1)
        assert all(np.isfinite(fmu.get(ANGLES)))


def test_no_pointer_is_no_crash():
    with Fmu(FMUS / "plant_f450_gimbal.fmu") as fmu:
        library = fmu.instance.dll
        nothing = ctypes.c_void_p()
        one = ctypes.c_size_t(1)
        assert library.fmi3DoStep(nothing, ctypes.c_double(0.0), ctypes.c_double(0.1), 0, *[nothing] * 4) == 3
        assert library.fmi3GetFloat64(nothing, nothing, one, nothing, one) == 3
        assert library.fmi3Reset(nothing) == 3
        assert library.fmi3GetFMUState(fmu.instance.component, nothing) == 3
        assert library.fmi3SetFMUState(fmu.instance.component, nothing) == 3
        assert library.fmi3SetString(fmu.instance.component, nothing, one, nothing, one) in (0, 3)
        library.fmi3FreeInstance(nothing)
        fmu.step(0.0, 0.1)


def test_every_function_of_the_standard_is_there():
    header = pathlib.Path(fmpy.__file__).parent / "c-code" / "fmi3Functions.h"
    names = {word for word in header.read_text().replace("(", " ").split() if word.startswith("fmi3")}
    names = {name for name in names if name[4:5].isupper() and not name.endswith(("TYPE", ";"))}
    names = {name for name in names if "FullName" not in name and name not in ("fmi3Version", "fmi3Functions_h")}
    assert len(names) > 70, sorted(names)
    with Fmu(FMUS / "controller_f450_gimbal.fmu") as fmu:
        missing = [name for name in sorted(names) if not hasattr(fmu.instance.dll, name)]
    assert missing == []


@pytest.mark.parametrize(
    "edit, told",
    [
        (lambda text: text.replace("arm_m", "arm_mm", 1), "arm_m"),
        (lambda text: "", "does not belong"),
        (lambda text: None, "model.toml"),
    ],
)
def test_a_bad_model_file_is_refused_with_its_place(edit, told, capfd):
    def change(folder):
        file = folder / "resources" / "model.toml"
        text = edit(file.read_text())
        file.unlink() if text is None else file.write_text(text)
        if text:
            # its token as well, or that would be the reason
            description = folder / "modelDescription.xml"
            old = fmpy.read_model_description(str(folder)).instantiationToken
            description.write_text(description.read_text().replace(old, f"plant-{fnv_1a(text):016x}"))

    messages = []
    with pytest.raises(Exception, match="instantiate"):
        logged(FMUS / "plant_f450_gimbal.fmu", change, messages)
    assert len(messages) == 1 and told in messages[0] and "model" in messages[0], messages
    if told == "arm_m":
        assert "model.toml:" in messages[0], "a mistake has its line"


def fnv_1a(text):
    value = 0xCBF29CE484222325
    for byte in text.encode():
        value = ((value ^ byte) * 0x100000001B3) % 2**64
    return value


def logged(path, edit, messages):
    """An instance whose first words are kept."""

    class Noted(Fmu):
        @property
        def log(self):
            return self

        @log.setter
        def log(self, _):
            pass

        def append(self, entry):
            messages.append(entry[1])

    Noted(path, edit=edit)


def test_a_controller_is_for_co_simulation_only():
    with Fmu(FMUS / "controller_f450_gimbal.fmu") as fmu:
        assert fmu.description.modelExchange is None
        instance = fmu.instance
        make = instance.dll.fmi3InstantiateModelExchange
        make.restype = ctypes.c_void_p
        resources = (pathlib.Path(fmu.folder.name) / "resources").as_posix().encode()
        told = []
        callback_type = type(instance.logMessage)
        callback = callback_type(lambda _environment, status, _category, text: told.append((status, text.decode())))
        token = fmu.description.instantiationToken.encode()
        made = make(b"x", token, resources, ctypes.c_bool(False), ctypes.c_bool(False), None, callback)
        assert made is None and told == [(3, "a controller is for co-simulation only")]
