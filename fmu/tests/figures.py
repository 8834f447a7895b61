"""The figures of docs/fmi.md: `cargo xtask fmu --figures` prints its tables."""

import contextlib
import io
import pathlib
import tempfile
import time

import numpy as np
from fmpy.validation import validate_fmu

from against_sil import (
    FMUS,
    NAMES,
    base_command,
    effort,
    fly,
    mean_abs_errors_deg,
    rows_of,
    without_noise_of_the_logger,
)
from fmus import ANGLES, Fmu, apart, by_cvode, by_its_own, closed_loop, reference_at, swing

# the thesis' test sequence, as sil-host/src/scenario.rs has it
SEGMENT_S = 1.75
POSITIONS_DEG = [(30, 0), (-30, 0), (0, 30), (0, -30), (30, 30), (30, -30), (-30, 30), (-30, -30)]
SEED = 7


def sequence():
    positions = [place for position in POSITIONS_DEG for place in ((0, 0), position)] + [(0, 0)]
    return [(number * SEGMENT_S, *place) for number, place in enumerate(positions)], len(positions) * SEGMENT_S


def closed(name, controller, plant_start=None, core_start=None, late=False):
    waypoints, duration_s = sequence()
    start = {"seed": SEED, "released_at_s": 2.0} | (plant_start or {})
    with (
        Fmu(FMUS / f"plant_imu_{name}.fmu", start=start) as plant,
        Fmu(FMUS / f"controller_{name}.fmu", start={"controller": controller} | (core_start or {})) as core,
    ):
        begin = time.perf_counter()
        angles, commands = closed_loop(plant, core, waypoints, duration_s, base_command(name), late)
        return angles, commands, (2.0 + duration_s) / (time.perf_counter() - begin)


def rms_deg(log, angles):
    """Of the error of roll and pitch."""
    return np.degrees(np.sqrt(np.mean((angles[:, :2] - rows_of(log, ["roll_ref_rad", "pitch_ref_rad"])) ** 2, axis=0)))


def open_loop():
    print("| model | model exchange against co-simulation |\n|---|---|")
    for name in NAMES:
        commands, path = swing(base_command(name)), FMUS / f"plant_{name}.fmu"
        # FMPy says of each input that is left at its start that it is
        with contextlib.redirect_stdout(io.StringIO()):
            difference = apart(by_its_own(path, commands), by_cvode(path, commands))
        print(f"| {name} | {difference:.1e} |")


def loops():
    print("\n| model, controller | angles, rad | commands | mean effort | mean errors | times real time |\n" + "|---" * 6 + "|")
    for name, controller in [(name, kind) for name in ("f450_gimbal", "f450_free") for kind in ("pid", "mpc")]:
        log, figures, angles, commands, speed = flown(name, controller)
        angle = np.abs(rows_of(log, ANGLES) - angles).max()
        command = np.abs(rows_of(log, [f"motor{motor}" for motor in (1, 2, 3, 4)]) - commands).max()
        difference = effort(commands, base_command(name)) - figures["effort"]
        waypoints, _ = sequence()
        references = [reference_at(waypoints, step * 2500 / 1e6) for step in range(len(angles))]
        own = [figures["axes"][axis]["mean_abs_error_deg"] for axis in ("roll", "pitch")]
        errors = max(abs(a - b) for a, b in zip(own, mean_abs_errors_deg(angles, references)))
        row = f"| {name}, {controller} | {angle:.1e} | {command:.1e} | {difference:.1e} | {errors:.1e} | {speed:.0f} |"
        print(row)


def flown(name, controller):
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        log, figures = fly(folder, without_noise_of_the_logger(name, folder), controller, SEED)
    return log, figures, *closed(name, controller)


def other_ways():
    print("\n| f450_gimbal | pid roll | pid pitch | mpc roll | mpc pitch |\n|---|---|---|---|---|")
    log = {kind: flown("f450_gimbal", kind)[0] for kind in ("pid", "mpc")}
    for what, options in [
        ("controller first, three samples a step", {}),
        ("both at once: commands a step late", {"late": True}),
        ("one sample a step", {"plant_start": {"imu_rate_hz": 400}, "core_start": {"imu_samples_per_step": 1}}),
    ]:
        errors = [rms_deg(log[kind], closed("f450_gimbal", kind, **options)[0]) for kind in ("pid", "mpc")]
        print(f"| {what} | " + " | ".join(f"{error:.3f}" for error in np.concatenate(errors)) + " |")


if __name__ == "__main__":
    fmus = sorted(FMUS.glob("*.fmu"))
    findings = sum(len(validate_fmu(str(path))) for path in fmus)
    print(f"FMPy's validation: {len(fmus)} FMUs, {findings} findings\n")
    open_loop()
    loops()
    other_ways()
