"""The FMUs as a co-simulation tool has them: validated, simulated and closed to a loop by FMPy, held against `sil`.

`cargo xtask fmu --check` runs this.
"""

import ctypes
import pathlib
import re
import subprocess

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

from against_sil import (
    FMUS,
    NAMES,
    SIL,
    base_command,
    effort,
    fly,
    mean_abs_errors_deg,
    model,
    rows_of,
    without_noise_of_the_logger,
)
from fmus import (
    ANGLES,
    COMMANDS,
    CONTROL_STEP_S,
    SAMPLES,
    Fmu,
    apart,
    by_cvode,
    by_its_own,
    closed_loop,
    reference_at,
    script,
    swing,
)

# of the test sequence's kind, with both axes at once
WAYPOINTS = [(0.5, 20.0, 0.0), (1.5, 0.0, -15.0), (2.5, -10.0, 10.0), (3.5, 0.0, 0.0)]
FLOWN_S = 4.5

PAGE = pathlib.Path(__file__).parents[2] / "docs" / "fmi.md"

# half of the log's last digit, and what rounding makes of it
LOG_DIGIT = 0.5e-6 + 1e-12


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


EFFECTS = {
    "": ("", ""),
    "delay, lag and a weak motor": (
        "actuation_delay:delay_s=0.004;motor_lag:time_constant_s=0.01; weak_motor:motor=2,scale=0.9",
        '[[effect]]\nname = "actuation_delay"\ndelay_s = 0.004\n[[effect]]\nname = "motor_lag"\ntime_constant_s = 0.01\n'
        '[[effect]]\nname = "weak_motor"\nmotor = 2\nscale = 0.9\n',
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
    """No tolerance: the same code, the same seed, the same instants. The log has six digits; the means over all commands
    and angles, of which each has all its digits, are equal to the bit."""
    short, tables = EFFECTS[effects]
    file = without_noise_of_the_logger(name, tmp_path, tables)
    log, figures = fly(tmp_path, file, controller, 7, script(WAYPOINTS, FLOWN_S))
    base = base_command(name)
    start = {"seed": 7, "released_at_s": 2.0, "effects": short}
    with (
        Fmu(FMUS / f"plant_imu_{name}.fmu", start=start) as plant,
        Fmu(FMUS / f"controller_{name}.fmu", start={"controller": controller}) as core,
    ):
        angles, commands = closed_loop(plant, core, WAYPOINTS, FLOWN_S, base)
    assert len(log) == len(angles) == FLOWN_S * 400
    assert np.abs(angles[:, :2]).max() > np.radians(14.0)
    assert np.abs(rows_of(log, ANGLES) - angles).max() < LOG_DIGIT
    assert np.abs(rows_of(log, [f"motor{motor}" for motor in (1, 2, 3, 4)]) - commands).max() < LOG_DIGIT
    assert effort(commands, base) == figures["effort"]
    references = [reference_at(WAYPOINTS, step * 2500 / 1e6) for step in range(len(angles))]
    means = [figures["axes"][axis]["mean_abs_error_deg"] for axis in ("roll", "pitch")]
    assert mean_abs_errors_deg(angles, references) == means


def test_another_seed_is_another_flight(tmp_path):
    file = without_noise_of_the_logger("f450_gimbal", tmp_path)
    _, figures = fly(tmp_path, file, "pid", 7, script(WAYPOINTS, FLOWN_S))
    with (
        Fmu(FMUS / "plant_imu_f450_gimbal.fmu", start={"seed": 8, "released_at_s": 2.0}) as plant,
        Fmu(FMUS / "controller_f450_gimbal.fmu") as core,
    ):
        _, commands = closed_loop(plant, core, WAYPOINTS, FLOWN_S, base_command("f450_gimbal"))
    assert effort(commands, base_command("f450_gimbal")) != figures["effort"]


@pytest.mark.parametrize(
    "name, effects",
    [(name, "") for name in NAMES]
    + [
        ("f450_gimbal", "actuation_delay:delay_s=0.006"),
        ("f450_gimbal", "motor_lag:time_constant_s=0.02"),
        ("f450_free", "actuation_delay:delay_s=0.0033; motor_lag:time_constant_s=0.02"),
        ("generic_gimbal", "step_disturbance:axis=roll,torque_nm=0.05,start_s=0.3012"),
    ],
)
def test_a_foreign_integrator_finds_the_plants_motion(name, effects):
    """Model exchange against co-simulation: another integrator on the same equations. The plant's Runge-Kutta takes
    steps of at most 0.5 ms and is accurate to some 1e-5 of the motion (sil-host/src/plant/integrate.rs), CVode to 1e-9;
    what they differ by is in docs/fmi.md."""
    commands = swing(base_command(name))
    start = {"effects": effects} if effects else {}
    path = FMUS / f"plant_{name}.fmu"
    own, foreign = by_its_own(path, commands, start), by_cvode(path, commands, start)
    assert own.shape == foreign.shape
    assert np.abs(own[:, :2]).max() > 0.1
    assert apart(own, foreign) < 1e-5


def test_effects_change_the_motion():
    commands, path = swing(base_command("f450_gimbal")), FMUS / "plant_f450_gimbal.fmu"
    nominal = by_its_own(path, commands)
    late = by_its_own(path, commands, {"effects": "actuation_delay:delay_s=0.006"})
    assert np.abs(nominal - late).max() > 1e-3


def test_what_holds_the_vehicle_lets_go_at_its_time():
    """A tilted vehicle: until then the IMU sees it level and still, from that very sample on it sees the tilt."""
    names = ["imu[1].specific_force_body_y_m_s2", "roll_rad"]
    start = {"roll_rad": 0.5, "released_at_s": 0.01, "disturbance_torque_body_x_nm": 0.05}
    with Fmu(FMUS / "plant_imu_f450_gimbal.fmu", start=start) as plant:
        for step in range(5):
            [force_m_s2, roll_rad] = plant.get(names)
            # at rest nothing but noise of 0.1 m/s^2, then g sin(0.5) = 4.7
            assert (abs(force_m_s2) > 4.0) == (step == 4), (step, force_m_s2)
            assert roll_rad == 0.5
            plant.step(step * CONTROL_STEP_S, CONTROL_STEP_S)
        assert plant.get(names)[1] > 0.5


def test_start_values_and_disturbances_act():
    with Fmu(FMUS / "plant_f450_gimbal.fmu", start={"roll_rad": 0.2, "disturbance_torque_body_y_nm": 0.01}) as plant:
        assert plant.get(["roll_rad"]) == [0.2]
        plant.step(0.0, 0.1)
        [roll_rad, pitch_rate] = plant.get(["roll_rad", "pitch_euler_rate_rad_s"])
        # by hand: level motors and a constant moment on body and ring, of which a tilt leaves the cosine
        assert abs(roll_rad - 0.2) < 1e-3
        expected = 0.01 * np.cos(0.2) / (0.0115118 * np.cos(0.2) ** 2 + 0.02 * np.sin(0.2) ** 2 + 0.0250533) * 0.1
        assert abs(pitch_rate / expected - 1.0) < 1e-3


def test_what_an_integrator_oversteps_is_put_right_at_an_event():
    """A rotor does not turn backwards, a rotation's quaternion has the length of one."""
    with Fmu(FMUS / "plant_f450_free.fmu", "ModelExchange") as plant:
        instance = plant.instance
        count = instance.getNumberOfContinuousStates()
        states = (ctypes.c_double * count)()

        def through_an_event():
            enter_event_mode, _ = instance.completedIntegratorStep()
            if not enter_event_mode:
                return None
            instance.enterEventMode()
            changed = instance.updateDiscreteStates()[3]
            instance.enterContinuousTimeMode()
            instance.getContinuousStates(states, count)
            return changed

        instance.updateDiscreteStates()
        instance.enterContinuousTimeMode()
        assert through_an_event() is None
        instance.getContinuousStates(states, count)
        names = [variable.name for variable in plant.description.modelVariables if variable.derivative]
        place = {name[4:-1]: index for index, name in enumerate(names)}
        states[place["motor3_speed_rad_s"]], states[place["q_world_from_body_x"]] = -1.0, 0.1
        instance.setContinuousStates(states, count)
        assert through_an_event() == 1
        assert states[place["motor3_speed_rad_s"]] == 0.0
        assert abs(states[place["q_world_from_body_x"]] - 0.1 / np.sqrt(1.01)) < 1e-15


def test_two_instances_do_not_meet():
    path = FMUS / "plant_f450_gimbal.fmu"
    commands = swing(base_command("f450_gimbal"))
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


@pytest.mark.parametrize("content", ["plant", "plant_imu", "controller"])
def test_time_begins_where_the_tool_wants(content):
    with Fmu(FMUS / f"{content}_f450_free.fmu", start_s=0.3) as fmu:
        refused(lambda: fmu.step(0.0, 0.1), fmu, "0.3 s have been reached")
        fmu.step(0.3, 0.1)
        assert fmu.get(["time"]) == [0.4]
        if content == "plant_imu":
            # at rest the newest sample of three shows gravity, as the others do
            down = fmu.get([f"imu[{sample}].specific_force_body_z_m_s2" for sample in (1, 2, 3)])
            assert all(abs(value + 9.81) < 1.0 for value in down)


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
        ("plant", {"effects": "motor_lag:time_constant_s=-1"}, "time_constant_s"),
        ("plant_imu", {"imu_rate_hz": 0}, "imu_rate_hz = 0: expected 1 to 8000"),
        ("controller", {"controller": "lqr"}, "lqr"),
        ("controller", {"controller": 'controller = "pid"\nrate_hz = 0'}, "rate"),
        ("controller", {"controller": 'controller = "pid"\nrate = 1'}, "rate"),
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


def test_a_rotation_that_is_none_is_refused():
    nowhere = {"q_world_from_body_w": 0.0}
    log = []
    with pytest.raises(FMICallException):
        Fmu(FMUS / "plant_f450_free.fmu", start=nowhere, log=log)
    assert log == [(3, "start values: the quaternion has no length")]
    half = {"q_world_from_body_w": 0.1, "q_world_from_body_x": 0.1}
    with Fmu(FMUS / "plant_f450_free.fmu", start=half) as plant:
        assert abs(plant.get(["roll_rad"])[0] - np.pi / 2) < 1e-12


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
        # without FMPy's own signatures, which let no such call through
        library = ctypes.CDLL(fmu.instance.dll._name)
        nothing = ctypes.c_void_p()
        one = ctypes.c_size_t(1)
        ours = ctypes.c_void_p(fmu.instance.component)
        assert library.fmi3DoStep(nothing, ctypes.c_double(0.0), ctypes.c_double(0.1), 0, *[nothing] * 4) == 3
        assert library.fmi3DoStep(ours, ctypes.c_double(0.0), ctypes.c_double(0.1), 0, *[nothing] * 4) == 0
        assert library.fmi3GetFloat64(nothing, nothing, one, nothing, one) == 3
        assert library.fmi3Reset(nothing) == 3
        assert library.fmi3GetFMUState(ours, nothing) == 3
        assert library.fmi3SetFMUState(ours, nothing) == 3
        assert library.fmi3SetString(ours, nothing, one, nothing, one) == 0
        library.fmi3FreeInstance(nothing)
        fmu.step(0.1, 0.1)


def test_every_function_of_the_standard_is_there():
    header = pathlib.Path(fmpy.__file__).parent / "c-code" / "fmi3Functions.h"
    names = set(re.findall(r"fmi3FullName\((fmi3[A-Z]\w+)\)", header.read_text()))
    assert len(names) > 70, sorted(names)
    with Fmu(FMUS / "controller_f450_gimbal.fmu") as fmu:
        missing = [name for name in sorted(names) if not hasattr(fmu.instance.dll, name)]
    assert missing == []


@pytest.mark.parametrize(
    "edit, told",
    [
        (lambda text: text.replace("arm_m", "arm_mm", 1), "model.toml:1:1: the model lacks `arm_m`"),
        (lambda text: text.replace("0.226", '"long"', 1), "model.toml:8:9: `arm_m` is of type string"),
        (lambda text: "", "does not belong"),
        (lambda text: None, "model.toml"),
    ],
)
def test_a_bad_model_file_is_refused_with_its_place(edit, told):
    def change(folder):
        file = folder / "resources" / "model.toml"
        text = edit(file.read_text())
        file.unlink() if text is None else file.write_text(text)
        if text:
            # its token as well, or that would be the reason
            description = folder / "modelDescription.xml"
            old = fmpy.read_model_description(str(folder)).instantiationToken
            description.write_text(description.read_text().replace(old, f"plant-{fnv_1a(text):016x}"))

    log = []
    with pytest.raises(Exception, match="instantiate"):
        Fmu(FMUS / "plant_f450_gimbal.fmu", edit=change, log=log)
    [(status, text)] = log
    assert status == 3 and told in text, log


def fnv_1a(text):
    value = 0xCBF29CE484222325
    for byte in text.encode():
        value = ((value ^ byte) * 0x100000001B3) % 2**64
    return value


def test_a_model_that_cannot_be_used_is_not_exported(tmp_path):
    (tmp_path / "bad.toml").write_text("rig = 3\n")
    for wrong, told in [("bad.toml", "error: bad.toml:1:1: the model lacks `name`"), ("none.toml", "error: none.toml: ")]:
        exporter, library = SIL.parent / "sil-fmu-export", SIL.parent / "libsil_fmu.so"
        command = [exporter, "--library", library, "--out", "fmus", model("f450_gimbal"), wrong]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 1 and done.stderr.startswith(told), done.stderr
        assert not (tmp_path / "fmus").exists()


def test_a_controller_is_for_co_simulation_only():
    with Fmu(FMUS / "controller_f450_gimbal.fmu") as fmu:
        assert fmu.description.modelExchange is None
        instance = fmu.instance
        make = instance.dll.fmi3InstantiateModelExchange
        make.restype = ctypes.c_void_p
        resources = str(fmu.folder / "resources").encode()
        told = []
        callback_type = type(instance.logMessage)
        callback = callback_type(lambda _environment, status, _category, text: told.append((status, text.decode())))
        token = fmu.description.instantiationToken.encode()
        made = make(b"x", token, resources, ctypes.c_bool(False), ctypes.c_bool(False), None, callback)
        assert made is None and told == [(3, "a controller is for co-simulation only")]


def table_names(page):
    """What stands in the first column of the tables of variables."""
    section = page.split("## Variables")[1].split("## Time")[0]
    cells = [line.split("|")[1] for line in section.splitlines() if line.startswith("| `")]
    return {name for cell in cells for name in re.findall(r"`([^`]+)`", cell)}


def general(name):
    """A variable's name as the page has it, with N, K, AXIS and PART."""
    for pattern, placeholder in [
        (r"^motor\d", "motorN"),
        (r"^imu\[\d\]", "imu[K]"),
        (r"q_world_from_body_[wxyz]", "q_world_from_body_PART"),
        (r"(body|ned)_[xyz]_", r"\1_AXIS_"),
    ]:
        name = re.sub(pattern, placeholder, name)
    return name


def test_the_page_has_every_variable_and_no_other():
    named = {
        general(variable.name)
        for path in FMUS.glob("*.fmu")
        for variable in fmpy.read_model_description(str(path)).modelVariables
        if variable.name != "time" and not variable.derivative
    }
    assert named == table_names(PAGE.read_text())


def test_the_pages_example_runs(monkeypatch, capsys):
    _, behind = PAGE.read_text().split("<!-- run by cargo xtask fmu --check -->\n```python\n")
    example, _ = behind.split("\n```", 1)
    monkeypatch.chdir(FMUS)
    exec(example, {})
    last = capsys.readouterr().out.strip().splitlines()[-1]
    # time, roll, pitch, a motor faster than at 0.5
    values = [float(value) for value in last.strip("()").split(",")]
    assert values[0] == 1.0 and abs(values[1]) > 0.1 and values[3] > 900.0
