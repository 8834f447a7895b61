from os import PathLike
from pathlib import Path
from typing import Any, Literal, Sequence

import numpy as np
from numpy.typing import NDArray

Series = NDArray[np.float64]
Triple = Sequence[float]
Sample = tuple[int, Sequence[int], Sequence[int]]
"""Microseconds, counts of the gyro, counts of the accelerometer."""

class SilError(ValueError):
    """A file, a log or a choice that can't be used; the text says why."""

class Model:
    """All that is known of a vehicle and of the rig it hangs in (docs/rig.md)."""

    @staticmethod
    def nominal(rig: Literal["gimbal", "free"] = "gimbal") -> Model:
        """The project's F450 on a rig."""
    @staticmethod
    def load(path: str | PathLike[str]) -> Model:
        """A model file."""
    @staticmethod
    def parse(text: str) -> Model:
        """The text of a model file."""
    def with_effects(self, effects: Sequence[str]) -> Model:
        """The same vehicle with more effects, as ``"weak_motor:motor=2,scale=0.9"`` (docs/effects.md)."""
    def draw(self, seed: int, number: int) -> Model:
        """A vehicle drawn from the model's tolerances, that of ``sil fly --draw`` (docs/montecarlo.md)."""
    def to_toml(self) -> str:
        """As a model file."""
    @property
    def name(self) -> str: ...
    @property
    def rig(self) -> str: ...
    @property
    def base_command(self) -> float:
        """Command at which all four motors rest at the start."""
    @property
    def inertia_kg_m2(self) -> list[float]:
        """Principal moments of inertia of the body alone."""
    @property
    def mass_kg(self) -> float | None:
        """None on the gimbal, where the mass moves nothing."""

class Flight:
    """A finished flight: one row per control step."""

    @property
    def time_s(self) -> Series:
        """Time since the rig let go, shape (n,)."""
    @property
    def reference_rad(self) -> Series:
        """Raw reference of roll and pitch, shape (n, 2)."""
    @property
    def angle_rad(self) -> Series:
        """True roll, pitch, yaw, shape (n, 3)."""
    @property
    def rate_body_rad_s(self) -> Series:
        """True body rates p, q, r, shape (n, 3)."""
    @property
    def commands(self) -> Series:
        """Commands of motors 1 to 4 in force from this row to the next, shape (n, 4)."""
    @property
    def torque_body_nm(self) -> Series:
        """Torque demanded of the mixer, shape (n, 3)."""
    @property
    def figures(self) -> dict[str, Any]:
        """The figures of ``sil fly --json`` (docs/commands.md)."""
    def log(self, rate_hz: int | None = None) -> Log:
        """As a log, at most as fast as the controller."""
    def __len__(self) -> int: ...

class Log:
    """A flight's rows in SI units (docs/log-format.md)."""

    @staticmethod
    def read(
        path: str | PathLike[str],
        *,
        map: str | None = None,
        flight: int | None = None,
        whole: bool = False,
        unchecked: bool = False,
    ) -> Log:
        """Any log that ``sil diagnose`` reads; ``map`` is a map's file or the name of one that ships."""
    @staticmethod
    def from_columns(columns: dict[str, Series]) -> Log:
        """Columns of one length under the names of docs/log-format.md, ``time_s`` among them."""
    def write(self, path: str | PathLike[str]) -> None:
        """As CSV, or as ULog if the name ends in .ulg."""
    def columns(self) -> dict[str, Series]:
        """What there is, by name."""
    @property
    def notes(self) -> list[str]:
        """Remarks of the reader."""
    @property
    def rate_hz(self) -> float: ...
    @property
    def duration_s(self) -> float: ...
    def __len__(self) -> int: ...

class Diagnosis:
    """What the simulation gets wrong in a log."""

    @property
    def text(self) -> str:
        """What ``sil diagnose`` prints."""
    @property
    def json(self) -> dict[str, Any]:
        """The fields of ``sil diagnose --json`` (docs/commands.md)."""
    def html(self) -> str:
        """The page of ``sil diagnose --report``."""
    def extended(self) -> Model | None:
        """The model with the findings in it; none of separate axes."""

class Study:
    """Vehicles drawn from a model's tolerances under the same controllers: what ``sil montecarlo`` flies.

    It is pickled as the texts that it is made of, so that its parts can be flown by other processes.
    """

    def __init__(
        self,
        model: Model,
        controllers: Sequence[str] = ["pid"],
        *,
        known: Model | None = None,
        script: str | None = None,
        seed: int = 0,
        options: str = "",
    ) -> None:
        """``options``: what ``sil fly`` takes beside the controller to fly one of its vehicles again, as ``" --model
        m.toml"``; it stands beside the rows."""
    def missing(self, runs: int, out: str | PathLike[str]) -> list[tuple[int, int]]:
        """First run and run after the last of the parts whose rows ``out`` lacks, with a folder for them beside it."""
    @staticmethod
    def path_of_part(part: tuple[int, int], out: str | PathLike[str]) -> Path:
        """Where the rows of a part stand until all of ``out``'s are there."""
    def fly_part(self, part: tuple[int, int], path: str | PathLike[str]) -> None:
        """Flies a part, one vehicle after the other, and writes its rows."""
    def collect(self, runs: int, out: str | PathLike[str]) -> tuple[int, int]:
        """Flies what is missing on all cores, all rows in one file; how many were flown, how many were there."""

class Plant:
    """The simulated vehicle with its state, at rest and level at time 0."""

    def __init__(self, model: Model) -> None: ...
    def set_commands(self, commands: Sequence[float]) -> None:
        """Commands of motors 1 to 4, 0..1, in force until the next."""
    def set_attitude(self, roll_pitch_yaw_rad: Triple, rate_body_rad_s: Triple) -> None:
        """Angles and body rates that it has from now on."""
    def set_disturbance_torque_body_nm(self, torque_body_nm: Triple) -> None:
        """Torque on the body from outside, until the next."""
    def advance(self, duration_s: float) -> None:
        """Lets time pass."""
    def truth(self) -> dict[str, Any]:
        """What is true now: ``angle_rad``, ``rate_body_rad_s``, ``position_ned_m``, ``velocity_ned_m_s``, ``lift_n``, ..."""
    def run(self, commands: Series, step_s: float) -> dict[str, Series]:
        """Flies commands of shape (steps, 4); ``time_s``, ``angle_rad`` and ``rate_body_rad_s`` at each step's end."""

class Sensors:
    """The IMU as its chip sends it, with the model's noise from a seed."""

    def __init__(self, model: Model, seed: int = 0) -> None: ...
    def imu(self, plant: Plant, time_us: int) -> Sample: ...
    def imu_at_rest(self, time_us: int) -> Sample:
        """Of a vehicle that stands level and still."""

class Core:
    """The control core that flies on the board, with the MPC's planner where there is one."""

    def __init__(self, model: Model, controller: str = "pid") -> None: ...
    @property
    def rates_hz(self) -> tuple[int, int]:
        """Steps of the core and samples of the IMU per second."""
    def step(
        self,
        time_us: int,
        imu: Sequence[Sample],
        *,
        roll_rad: float = 0.0,
        pitch_rad: float = 0.0,
        yaw_rate_rad_s: float = 0.0,
        throttle: float = 0.0,
        arm: bool = False,
    ) -> list[float]:
        """One step with the samples since the last; the commands of motors 1 to 4."""

def fly(
    model: Model, controller: str = "pid", *, known: Model | None = None, script: str | None = None, seed: int = 0
) -> Flight:
    """Flies the test sequence or a script.

    ``controller`` is ``"pid"``, ``"mpc"``, the path of a controller file or the text of one; ``script`` a path or a
    text; ``known`` what the controller takes the vehicle for, by default the model without its effects.
    """

def synth(
    model: Model,
    controller: str = "pid",
    *,
    script: str | None = None,
    duration_s: float | None = None,
    rate_hz: int = 200,
    seed: int = 0,
) -> Log:
    """A log with the model's effects in it, integrated by another method than flights are."""

def diagnose(
    log: Log,
    model: Model | None = None,
    *,
    controller: str | None = None,
    known: Sequence[str] = (),
    effort: Literal["quick", "usual", "thorough"] = "usual",
) -> Diagnosis:
    """What the simulation gets wrong in a log. Without a model the vehicle is identified from the log first.

    ``known`` holds numbers fixed, as ``"mass_kg=0.027"``.
    """

def compare(log: Log, model: Model | None = None, *, controller: str | None = None) -> dict[str, Any]:
    """How well a model predicts a log: the fields of ``sil compare --json``."""

def identify(
    logs: Sequence[Log], *, mass_kg: float | None = None, arm_m: float | None = None
) -> tuple[Model, list[dict[str, Any]]]:
    """A vehicle from its own logs, and each of its numbers with its interval."""

def margins(model: Model, controller: str = "pid", *, known: Model | None = None) -> list[dict[str, float]] | None:
    """Margins of roll and pitch in hover, measured on the running code; None where the loop oscillates by itself."""

def tuning(model: Model, controller: str = "pid", *, known: Model | None = None) -> dict[str, Any]:
    """All numbers of a tuning, by the keys of a controller file."""
