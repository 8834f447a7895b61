"""What the package answers, held against the command line, against itself and against mechanics."""

import json
import os
import subprocess

import numpy as np
import pytest

import sil_host as sil

SIL = os.environ["SIL"]
EFFECT = "cg_offset:axis=pitch,cos_moment_nm=0.1,sin_moment_nm=0"


def command(*arguments, cwd):
    done = subprocess.run([SIL, *arguments], cwd=cwd, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("controller", ["pid", "mpc"])
def test_a_flight_is_the_command_lines(controller, tmp_path):
    figures = sil.fly(sil.Model.nominal("free"), controller, seed=3).figures
    told = json.loads(command("fly", "--rig", "free", "--controller", controller, "--seed", "3", "--json", "-", cwd=tmp_path))
    (run,) = told["runs"]
    for axis in ("roll", "pitch"):
        assert figures["axes"][axis] == {key: run["axes"][axis][key] for key in figures["axes"][axis]}
    assert figures["effort"] == run["effort"]


def test_series_have_a_row_per_step():
    flight = sil.fly(sil.Model.nominal(), "pid")
    assert len(flight) == 29.75 * 400
    assert flight.time_s.shape == (len(flight),) and flight.commands.shape == (len(flight), 4)
    assert flight.angle_rad.shape == (len(flight), 3) and flight.angle_rad.dtype == np.float64
    error = np.rad2deg(flight.angle_rad[:, 0] - flight.reference_rad[:, 0])
    rms = flight.figures["axes"]["roll"]["rms_error_deg"]
    assert np.sqrt(np.square(error).mean()) == pytest.approx(rms, rel=1e-12)


def test_a_diagnosis_is_the_command_lines_and_its_model_is_better(tmp_path):
    log = sil.synth(sil.Model.nominal().with_effects([EFFECT]), duration_s=12.0, seed=5)
    log.write(tmp_path / "x.csv")
    answer = sil.diagnose(log, sil.Model.nominal(), effort="quick")
    told = json.loads(command("diagnose", "x.csv", "--quick", "--rig", "gimbal", "--json", "-", cwd=tmp_path))
    (finding,) = answer.json["findings"]
    assert finding["effect"] == "cg_offset"
    moment = finding["parameters"]["cos_moment_nm"]
    assert abs(moment["value"] - 0.1) < 5 * moment["std"]
    # a CSV rounds what the log in memory does not
    assert told["findings"][0]["parameters"]["cos_moment_nm"]["value"] == pytest.approx(moment["value"], rel=1e-3)
    extended = answer.extended()
    pitch_deg = [
        {one["quantity"]: one["nominal"] for one in sil.compare(log, model)["prediction_error"]["channels"]}["pitch"]
        for model in (sil.Model.nominal(), extended)
    ]
    assert pitch_deg[1] < 0.1 * pitch_deg[0], pitch_deg
    assert "Diagnosis of" in answer.html() and "cg_offset" in sil.Model.parse(extended.to_toml()).to_toml()


def test_a_log_goes_through_columns_and_files(tmp_path):
    log = sil.synth(sil.Model.nominal("free"), duration_s=6.0, seed=1)
    columns = log.columns()
    again = sil.Log.from_columns(columns).columns()
    assert columns.keys() == again.keys()
    assert all(np.array_equal(columns[name], again[name]) for name in columns)
    log.write(tmp_path / "x.ulg")
    assert len(sil.Log.read(tmp_path / "x.ulg", whole=True)) == len(log)


def test_a_foreign_flight_is_identified():
    logs = [sil.synth(sil.Model.nominal("free"), duration_s=20.0, rate_hz=200, seed=seed) for seed in (1, 2)]
    model, numbers = sil.identify(logs, mass_kg=1.2, arm_m=0.226)
    assert model.rig == "free" and any(number["name"] == "motor_lag_s" for number in numbers)
    truth = sil.Model.nominal("free").inertia_kg_m2
    assert model.inertia_kg_m2[:2] == pytest.approx(truth[:2], rel=0.1)


def test_the_plant_falls_and_batches_are_its_steps():
    model = sil.Model.nominal("free")
    plant = sil.Plant(model)
    plant.set_commands([0.0] * 4)
    plant.advance(2.0)
    # the rotors stop within a few tenths of a second
    assert 0.8 * 19.62 < plant.truth()["velocity_ned_m_s"][2] < 19.62
    commands = model.base_command + 0.05 * np.sin(np.arange(400)[:, None] * 0.1 + np.arange(4))
    one, all_at_once = sil.Plant(model), sil.Plant(model)
    angles = []
    for row in commands:
        one.set_commands(row)
        one.advance(0.0025)
        angles.append(one.truth()["angle_rad"])
    assert np.array_equal(np.array(angles), all_at_once.run(commands, 0.0025)["angle_rad"])


def test_the_core_flies_the_plant():
    """The loop of `sil fly`, made of its parts: to the bit."""
    model = sil.Model.nominal("free")
    core, plant, sensors = sil.Core(model, "pid"), sil.Plant(model), sil.Sensors(model, seed=7)
    control_hz, imu_hz = core.rates_hz
    held_us, flown = 2_000_000, sil.fly(model, "pid", seed=7)
    batch, commands, angles = [], None, []
    now_us = 0
    for tick in range(3 * imu_hz):
        at_us = (tick * 1_000_000 + imu_hz // 2) // imu_hz
        if now_us >= held_us:
            plant.advance((at_us - now_us) * 1e-6)
        now_us = at_us
        batch.append(sensors.imu(plant, at_us) if at_us >= held_us else sensors.imu_at_rest(at_us))
        if tick % (imu_hz // control_hz):
            continue
        hovers, arms = at_us >= held_us // 20 * 19, at_us >= held_us // 20 * 18
        throttle = model.base_command if hovers else 0.0
        commands = core.step(at_us, batch, throttle=throttle, arm=arms and not hovers)
        batch = []
        if at_us >= held_us:
            plant.set_commands(commands)
            angles.append(plant.truth()["angle_rad"])
    # up to the sequence's first position, at 1.75 s
    assert np.array_equal(np.array(angles), flown.angle_rad[: len(angles)])


def test_what_cannot_be_used_is_refused_with_its_reason(tmp_path):
    for wrong, told in [
        (lambda: sil.Model.nominal("boat"), 'expected "gimbal" or "free"'),
        (lambda: sil.Model.parse("rig = 3"), "model:1:1"),
        (lambda: sil.Model.nominal().with_effects(["wobble:x=1"]), "wobble"),
        (lambda: sil.fly(sil.Model.nominal(), "lqr"), "lqr"),
        (lambda: sil.Log.read(tmp_path / "none.csv"), "none.csv"),
        (lambda: sil.Log.from_columns({"time_s": np.arange(3.0), "roll_rad": np.zeros(2)}), "one length"),
        (lambda: sil.Plant(sil.Model.nominal()).advance(-1.0), "forward"),
        (lambda: sil.Plant(sil.Model.nominal()).run(np.zeros((5, 3)), 0.01), "(steps, 4)"),
    ]:
        with pytest.raises(sil.SilError, match=None) as caught:
            wrong()
        assert told in str(caught.value), str(caught.value)


def test_the_stubs_name_what_there_is():
    import ast
    import pathlib

    text = (pathlib.Path(sil.__file__).parent / "_native.pyi").read_text()
    for node in ast.parse(text).body:
        if isinstance(node, ast.ClassDef):
            real = getattr(sil, node.name)
            members = [inner.name for inner in node.body if isinstance(inner, ast.FunctionDef)]
            assert all(hasattr(real, name) for name in members), node.name
            shown = {name for name in vars(real) if not name.startswith("_")}
            assert shown <= set(members), f"{node.name}: {shown - set(members)}"
        elif isinstance(node, ast.FunctionDef):
            assert callable(getattr(sil, node.name))


def test_the_environment_is_one_that_gymnasium_knows():
    gymnasium = pytest.importorskip("gymnasium")
    from gymnasium.utils.env_checker import check_env

    from sil_host.gym import AttitudeEnv

    check_env(AttitudeEnv())
    env = AttitudeEnv()
    first = [env.reset(seed=4)[0], *(env.step(np.full(4, 0.5, np.float32))[0] for _ in range(20))]
    again = [env.reset(seed=4)[0], *(env.step(np.full(4, 0.5, np.float32))[0] for _ in range(20))]
    assert np.array_equal(first, again)
    assert isinstance(env, gymnasium.Env)
    # nobody steers: it falls or the time is over
    env.reset(seed=4)
    steps = [env.step(np.array([0.6, 0.5, 0.5, 0.5], np.float32)) for _ in range(300)]
    assert any(has_fallen for _, _, has_fallen, _, _ in steps)
