"""What `sil fly` says of the vehicles that the FMUs are made of.

From the environment: FMUS is the folder of the FMUs, MODELS that of their models, SIL the command line.
"""

import csv
import json
import math
import os
import pathlib
import subprocess

import numpy as np

FMUS, MODELS, SIL = (pathlib.Path(os.environ[name]) for name in ("FMUS", "MODELS", "SIL"))
NAMES = [f"{level}_{rig}" for rig in ("gimbal", "free") for level in ("f450", "generic", "box")]


def model(name):
    return MODELS / f"{name.replace('_', '-')}.toml"


def base_command(name):
    """The command at which the vehicle hovers."""
    [line] = [line for line in model(name).read_text().splitlines() if line.startswith("base_command")]
    return float(line.split("=")[1].split("#")[0])


def without_noise_of_the_logger(name, folder, effects=""):
    """A model whose logged angles are the true ones; what the controller gets stays noisy."""
    lines = model(name).read_text().splitlines(keepends=True)
    text = "".join("attitude_rad = 0.0\n" if line.startswith("attitude_rad") else line for line in lines)
    file = folder / "quiet-log.toml"
    file.write_text(text + effects)
    return file


def fly(folder, file, controller, seed, script=None):
    """Rows of the log and figures of a flight, of the test sequence where there is no script."""
    command = [SIL, "fly", "--quiet", "--model", file, "--controller", controller, "--seed", str(seed)]
    if script is not None:
        (folder / "script.toml").write_text(script)
        command += ["--script", "script.toml"]
    subprocess.run([*command, "--log", "log.csv", "--json", "figures.json"], cwd=folder, check=True)
    with (folder / "log.csv").open() as log:
        rows = list(csv.DictReader(line for line in log if not line.startswith("#")))
    return rows, json.loads((folder / "figures.json").read_text())["runs"][0]


def rows_of(log, columns):
    return np.array([[float(row[column]) for column in columns] for row in log])


def effort(commands, base):
    """Mean |command - base|, summed in the order of `sil`: another last bit of any command shows."""
    total = 0.0
    for row in commands:
        total += sum(abs(command - base) for command in row) / 4.0
    return total / len(commands)


def mean_abs_errors_deg(angles, references):
    """Of roll and pitch, likewise."""
    means = []
    for axis in (0, 1):
        total = 0.0
        for angle, reference in zip(angles, references):
            total += abs(reference[axis] - angle[axis])
        means.append(math.degrees(total / len(angles)))
    return means
