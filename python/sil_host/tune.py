"""Gains and weights by multi-objective search (thesis, section 7.3.1): ``python -m sil_host.tune --help``.

A trial scales keys of the tuning that follows from the vehicle; its figures come from flights of the model and of
vehicles drawn from its tolerances, a push, a hover and the measured margins. Optuna's NSGA-II searches; the tuning that
follows from the vehicle is the first trial, so that the front says how good it was.
"""

from __future__ import annotations

import argparse
import concurrent.futures
import csv
import functools
import math
import pathlib
import sys
from dataclasses import dataclass
from typing import Any, Callable, Sequence, Union

import numpy as np
import optuna
import tqdm

from . import Model, SilError, fly, margins, tuning

#: Keys that a trial scales, and by how much at most, either way.
SCALED: dict[str, dict[str, float]] = {
    "pid": {
        "shaping_gain_1_s": 3.0,
        "acceleration_share": 3.0,
        "angle_gain_1_s": 4.0,
        "rate_proportional_1_s": 3.0,
        "rate_integral_1_s2": 4.0,
        "rate_derivative": 10.0,
        "rate_derivative_cutoff_hz": 2.0,
    },
    "mpc": {
        "shaping_gain_1_s": 3.0,
        "acceleration_share": 3.0,
        "mpc_increment_weight": 30.0,
        "mpc_lead_s": 3.0,
        "mpc_disturbance_bandwidth_rad_s": 4.0,
        "gyro_cutoff_hz": 2.0,
    },
}

#: Figures of a trial; less is better but of the margins.
FIGURES = {
    "rms_deg": "root mean square error of roll and pitch in the test sequence, mean over the vehicles",
    "rms_worst_deg": "the same of the worst of them",
    "rise_s": "10 to 90 % of a step, mean",
    "overshoot_pct": "past the target, % of a step, mean",
    "settling_s": "until the error stays within 3 degrees, mean; a step that never does counts 1.75 s",
    "steady_deg": "error before the next step, mean",
    "effort": "mean deviation of the commands from hover",
    "push_deg": "largest angle after a torque of 9 rad/s^2 times the inertia, the worse of roll and pitch",
    "noise": "standard deviation of the commands in hover, from the sensors' noise",
    "delay_margin_ms": "delay that may be added, the worse of roll and pitch",
    "gain_margin_db": "factor by which the gain may rise",
    "phase_margin_deg": "phase that may be lost",
    "sensitivity_peak": "largest sensitivity",
}
MORE_IS_BETTER = {"delay_margin_ms", "gain_margin_db", "phase_margin_deg"}

PUSH_RAD_S2 = 9.0
HOVER_SCRIPT = "duration_s = 6.0\n"
#: From when on a hover is settled, and pushed, s.
SETTLED_S = 2.0
SEGMENT_S = 1.75
#: Draws of the search; what is chosen is confirmed on others.
DRAWS_SEED = 1
UNSEEN_SEED = 2
POPULATION = 40


@dataclass(frozen=True)
class Task:
    """What is tuned, and on what."""

    model: Model
    controller: str
    draws: int = 4
    noise_seed: int = 1

    def controller_text(self, factors: dict[str, float]) -> str:
        """A controller file: the tuning that follows from the vehicle, some of its keys scaled."""
        nominal = tuning(self.model, self.controller)
        lines = [f'controller = "{self.controller}"', "[tuning]"]
        for key, factor in factors.items():
            value = nominal[key]
            scaled = [factor * one for one in value] if isinstance(value, list) else factor * value
            lines.append(f"{key} = {scaled}")
        return "\n".join(lines) + "\n"

    def figures(self, controller: str, draws_seed: int = DRAWS_SEED, draws: int | None = None) -> dict[str, float]:
        """All figures of a controller file's text. The controller takes every drawn vehicle for the model."""
        count = self.draws if draws is None else draws
        vehicles = [self.model, *(self.model.draw(draws_seed, number) for number in range(count))]
        flights = [
            fly(vehicle, controller, known=self.model, seed=self.noise_seed + number).figures
            for number, vehicle in enumerate(vehicles)
        ]
        axes = [flight["axes"][axis] for flight in flights for axis in ("roll", "pitch")]

        def mean(key: str, never: float = math.inf) -> float:
            return float(np.mean([never if axis[key] is None else axis[key] for axis in axes]))

        rms = [
            math.sqrt(np.mean([flight["axes"][axis]["rms_error_deg"] ** 2 for axis in ("roll", "pitch")]))
            for flight in flights
        ]
        return {
            "rms_deg": float(np.mean(rms)),
            "rms_worst_deg": float(np.max(rms)),
            "rise_s": mean("rise_time_s", SEGMENT_S),
            "overshoot_pct": mean("overshoot_pct"),
            "settling_s": mean("settling_time_s", SEGMENT_S),
            "steady_deg": mean("steady_error_deg"),
            "effort": float(np.mean([flight["effort"] for flight in flights])),
            "push_deg": max(self._push_deg(controller, axis) for axis in (0, 1)),
            "noise": self._noise(controller),
            **self._margins(controller),
        }

    def _push_deg(self, controller: str, axis: int) -> float:
        torque_nm = PUSH_RAD_S2 * self.model.inertia_kg_m2[axis]
        effect = f"step_disturbance:axis={('roll', 'pitch')[axis]},torque_nm={torque_nm},start_s={SETTLED_S}"
        flight = fly(self.model.with_effects([effect]), controller, known=self.model, script=HOVER_SCRIPT)
        return float(np.rad2deg(np.abs(flight.angle_rad[:, axis]).max()))

    def _noise(self, controller: str) -> float:
        flight = fly(self.model, controller, script=HOVER_SCRIPT, seed=self.noise_seed)
        settled = flight.commands[flight.time_s >= SETTLED_S]
        return float(np.sqrt(np.mean(settled.var(axis=0))))

    def _margins(self, controller: str) -> dict[str, float]:
        measured = margins(self.model, controller)
        if measured is None:
            return {"delay_margin_ms": 0.0, "gain_margin_db": 0.0, "phase_margin_deg": 0.0, "sensitivity_peak": 100.0}

        def least(key: str) -> float:
            # a margin that nothing measured limits is no limit
            return min(1e3 if axis[key] is None else axis[key] for axis in measured)

        return {
            "delay_margin_ms": least("delay_ms"),
            "gain_margin_db": least("gain_db"),
            "phase_margin_deg": least("phase_deg"),
            "sensitivity_peak": max(axis["sensitivity_peak"] for axis in measured),
        }


#: The figures of a controller, or why it can't fly.
Judgement = Union[dict[str, float], str]


def judged(task: Task, controller: str) -> Judgement:
    """Figures of a controller file's text; a number beyond what a controller file admits is no reason to stop."""
    try:
        return task.figures(controller)
    except SilError as refused:
        return str(refused)


def judge_on_threads(task: Task, controllers: Sequence[str]) -> list[Judgement]:
    """All of them at once: flights do not hold the interpreter."""
    with concurrent.futures.ThreadPoolExecutor(len(controllers)) as threads:
        return list(threads.map(functools.partial(judged, task), controllers))


@dataclass(frozen=True)
class Limit:
    """A figure that has to be kept."""

    figure: str
    value: float
    at_least: bool

    def __str__(self) -> str:
        return f"{self.figure} {'>=' if self.at_least else '<='} {self.value:g}"

    def missed_by(self, figures: dict[str, float]) -> float:
        """Above 0 where it is not kept."""
        over = figures[self.figure] - self.value
        return -over if self.at_least else over

    @staticmethod
    def parse(text: str, at_least: bool) -> Limit:
        figure, sign, value = text.partition("=")
        if figure not in FIGURES or not sign:
            raise argparse.ArgumentTypeError(f"{text!r}: expected FIGURE=VALUE, FIGURE one of {', '.join(FIGURES)}")
        try:
            return Limit(figure, float(value), at_least)
        except ValueError:
            raise argparse.ArgumentTypeError(f"{text!r}: {value!r} is no number") from None


def search(
    task: Task,
    objectives: Sequence[str],
    limits: Sequence[Limit],
    trials: int,
    *,
    seed: int = 1,
    storage: str | None = None,
    jobs: int = 1,
    judge: Callable[[Task, Sequence[str]], list[Judgement]] = judge_on_threads,
    show_progress: bool = False,
) -> optuna.Study:
    """Searches, ``jobs`` trials at once; goes on from what a storage holds.

    The first trial is the tuning that follows from the vehicle. The same seed and the same ``jobs`` give the same
    trials, whoever judges them.
    """
    study = optuna.create_study(
        study_name=f"{task.model.name}, {task.controller}, {' '.join(objectives)}",
        directions=["maximize" if name in MORE_IS_BETTER else "minimize" for name in objectives],
        sampler=optuna.samplers.NSGAIISampler(seed=seed, population_size=POPULATION),
        storage=storage,
        load_if_exists=storage is not None,
    )
    if not study.trials:
        study.enqueue_trial({key: 1.0 for key in SCALED[task.controller]})

    left = trials - sum(trial.state.is_finished() for trial in study.trials)
    bar = tqdm.tqdm(total=max(left, 0), disable=not show_progress)
    while left > 0:
        asked = [study.ask() for _ in range(min(jobs, left))]
        texts = [task.controller_text(_factors(trial, task.controller)) for trial in asked]
        for trial, judgement in zip(asked, judge(task, texts)):
            _tell(study, trial, judgement, objectives, limits)
        left -= len(asked)
        bar.update(len(asked))
    bar.close()
    return study


def _factors(trial: optuna.Trial, controller: str) -> dict[str, float]:
    return {key: trial.suggest_float(key, 1.0 / most, most, log=True) for key, most in SCALED[controller].items()}


def _tell(
    study: optuna.Study,
    trial: optuna.Trial,
    judgement: Judgement,
    objectives: Sequence[str],
    limits: Sequence[Limit],
) -> None:
    if isinstance(judgement, str):
        trial.set_user_attr("refused", judgement)
        study.tell(trial, state=optuna.trial.TrialState.PRUNED)
        return
    trial.set_user_attr("figures", judgement)
    for limit in limits:
        trial.set_constraint(str(limit), limit.missed_by(judgement))
    study.tell(trial, [judgement[name] for name in objectives])


def front(study: optuna.Study) -> list[optuna.trial.FrozenTrial]:
    """The trials that keep the limits and that no other is better than in every objective, by the first of these."""
    # a search tries some points twice
    points = {tuple(trial.params.values()): trial for trial in reversed(study.best_trials)}
    return sorted(points.values(), key=lambda trial: trial.values[0])


def improved_by(study: optuna.Study, trial: optuna.trial.FrozenTrial) -> float:
    """By which share at least one trial of the front is better than this one in every objective; 0 on the front."""
    directions = [1.0 if one == optuna.study.StudyDirection.MINIMIZE else -1.0 for one in study.directions]

    def gain(other: optuna.trial.FrozenTrial) -> float:
        pairs = zip(directions, trial.values, other.values)
        return min(sign * (own - theirs) / abs(own) if own else 0.0 for sign, own, theirs in pairs)

    return max([0.0, *(gain(other) for other in study.best_trials)])


def write(study: optuna.Study, task: Task, objectives: Sequence[str], folder: pathlib.Path) -> None:
    """`front.csv`, `front.html`, and the controller file of each point of the front."""
    folder.mkdir(parents=True, exist_ok=True)
    points = front(study)
    with open(folder / "front.csv", "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["trial", *FIGURES, *SCALED[task.controller]])
        for point in points:
            figures = point.user_attrs["figures"]
            table.writerow([point.number, *(figures[name] for name in FIGURES), *point.params.values()])
    for point in points:
        (folder / f"trial-{point.number}.toml").write_text(task.controller_text(point.params))
    if 2 <= len(objectives) <= 3:
        plot = optuna.visualization.plot_pareto_front(study, target_names=list(objectives))
        plot.write_html(folder / "front.html", include_plotlyjs=True)


def _row(name: str, figures: dict[str, float], shown: Sequence[str]) -> str:
    return f"{name:>10}  " + "  ".join(f"{figures[figure]:>{len(figure)}.4g}" for figure in shown)


def arguments() -> argparse.ArgumentParser:
    """What the command takes."""
    parser = argparse.ArgumentParser(prog="python -m sil_host.tune", description=__doc__.split("\n\n")[0])
    parser.add_argument("--model", help="model file with tolerances [default: the F450 on the gimbal]")
    parser.add_argument("--controller", choices=sorted(SCALED), default="pid")
    parser.add_argument("--trials", type=int, default=200, help="in all, those of an earlier run included")
    parser.add_argument("--draws", type=int, default=4, help="vehicles beside the model's own")
    parser.add_argument("--seed", type=int, default=1, help="of the search")
    parser.add_argument(
        "--objectives",
        nargs="+",
        choices=list(FIGURES),
        default=["rms_deg", "push_deg", "noise"],
        metavar="FIGURE",
        help="; ".join(f"{name}: {meaning}" for name, meaning in FIGURES.items()),
    )
    at_least = functools.partial(Limit.parse, at_least=True)
    at_most = functools.partial(Limit.parse, at_least=False)
    parser.add_argument("--at-least", type=at_least, action="append", metavar="FIGURE=VALUE", help="a figure to keep")
    parser.add_argument("--at-most", type=at_most, action="append", metavar="FIGURE=VALUE", help="likewise")
    parser.add_argument("--storage", help="Optuna's, as sqlite:///tune.db: kept, gone on from, seen in its dashboard")
    parser.add_argument("--jobs", type=int, default=1, help="trials at once; another number is another search")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/tune"), help="folder of what is written")
    parser.add_argument("--pick", type=int, help="fly this trial of the front again on vehicles that no trial saw")
    parser.add_argument("--confirm", type=int, default=50, help="how many those are")
    parser.add_argument("--quiet", action="store_true")
    return parser


def main(given: Sequence[str] | None = None) -> int:
    """The command."""
    try:
        return run(arguments().parse_args(given), judge_on_threads)
    except SilError as refused:
        print(f"error: {refused}", file=sys.stderr)
        return 2


def run(options: Any, judge: Callable[[Task, Sequence[str]], list[Judgement]]) -> int:
    """Searches as the command was told, writes the front and prints it."""
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    model = Model.load(options.model) if options.model else Model.nominal()
    task = Task(model, options.controller, options.draws)
    limits = [*(options.at_least or []), *(options.at_most or [])]
    if not limits:
        limits = [Limit("delay_margin_ms", 10.0, True), Limit("sensitivity_peak", 2.0, False)]
    study = search(
        task,
        options.objectives,
        limits,
        options.trials,
        seed=options.seed,
        storage=options.storage,
        jobs=options.jobs,
        judge=judge,
        show_progress=not options.quiet,
    )
    write(study, task, options.objectives, options.out)
    return report(study, task, options, limits)


def report(study: optuna.Study, task: Task, options: Any, limits: Sequence[Limit]) -> int:
    """What is printed: the front, where the shipped tuning lies, and the point that was picked on unseen vehicles."""
    shown = list(dict.fromkeys([*options.objectives, *(limit.figure for limit in limits)]))
    print("     trial  " + "  ".join(shown))
    for point in front(study):
        print(_row(str(point.number), point.user_attrs["figures"], shown))
    shipped = study.trials[0]
    print(_row("shipped", shipped.user_attrs["figures"], shown))
    share = improved_by(study, shipped)
    print(f"the shipped tuning can be improved by {100.0 * share:.1f} % in every objective at once")
    print(f"written: {options.out}/front.csv, front.html, trial-*.toml")
    if options.pick is not None:
        picked = [point for point in front(study) if point.number == options.pick]
        if not picked:
            print(f"error: trial {options.pick} is not on the front", file=sys.stderr)
            return 2
        text = task.controller_text(picked[0].params)
        print(f"on {options.confirm} vehicles that no trial saw:")
        for name, controller in ((str(options.pick), text), ("shipped", task.controller_text(shipped.params))):
            print(_row(name, task.figures(controller, UNSEEN_SEED, options.confirm), shown))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
