"""Studies and searches on all machines of a Ray cluster, or on the cores of this one.

Without ``--address`` Ray is started here, a worker a core, and ends with the command: the same command runs on a laptop
and, with ``--address auto`` or ``--address HOST:PORT``, on a cluster whose machines have this package. What a worker
takes along when it dies is flown again by another. Rows and searches do not depend on who computed what.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import pathlib
import sys
import tempfile
from typing import Any, Callable, Iterator, Sequence

import ray

from . import Model, SilError, Study, tune

#: How often a part is given to another worker after one died with it.
RETRIES = 20


@contextlib.contextmanager
def cluster(address: str | None = None, workers: int | None = None) -> Iterator[int]:
    """A Ray cluster for a while; how many workers it has."""
    environment = {"env_vars": {"RAYON_NUM_THREADS": "1"}}
    options: dict[str, Any] = {"runtime_env": environment, "log_to_driver": False, "logging_level": "ERROR"}
    if address is None:
        options |= {"num_cpus": workers, "include_dashboard": False}
    ray.init(address, **options)
    try:
        yield int(ray.cluster_resources()["CPU"])
    finally:
        ray.shutdown()


@ray.remote(max_retries=RETRIES)
def _rows_of_part(study: Study, part: tuple[int, int]) -> bytes:
    # machines of a cluster have no folder in common: the file itself goes back
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "part.parquet"
        study.fly_part(part, path)
        return path.read_bytes()


def montecarlo(
    study: Study, runs: int, out: pathlib.Path, progress: Callable[[int, int], None] = lambda done, all_: None
) -> tuple[int, int]:
    """Flies what is missing of a study on the cluster; how many vehicles were flown and how many were there already.

    Parts of 200 appear beside ``out`` as they come, whole or not at all, as those of ``sil montecarlo``, which can go on
    from them, as this can from its.
    """
    missing = study.missing(runs, out)
    flown = sum(end - begin for begin, end in missing)
    shared = ray.put(study)
    pending = {_rows_of_part.remote(shared, part): part for part in missing}
    done = runs - flown
    progress(done, runs)
    while pending:
        (ready, *_), _ = ray.wait(list(pending))
        part = pending.pop(ready)
        _keep(study.path_of_part(part, out), ray.get(ready))
        done += part[1] - part[0]
        progress(done, runs)
    study.collect(runs, out)
    return flown, runs - flown


def _keep(path: pathlib.Path, rows: bytes) -> None:
    unfinished = path.with_suffix(".unfinished")
    unfinished.write_bytes(rows)
    os.replace(unfinished, path)


@ray.remote(max_retries=RETRIES)
def _judged(task: tune.Task, controller: str) -> tune.Judgement:
    return tune.judged(task, controller)


def judge(task: tune.Task, controllers: Sequence[str]) -> list[tune.Judgement]:
    """Figures of controllers, each of which another worker flies."""
    shared = ray.put(task)
    return ray.get([_judged.remote(shared, controller) for controller in controllers])


def arguments() -> argparse.ArgumentParser:
    """What the command takes."""
    parser = argparse.ArgumentParser(prog="python -m sil_host.cluster", description=__doc__.split("\n\n")[0])
    parser.add_argument("--address", help="of a running cluster, or auto [default: one is started on this machine]")
    parser.add_argument("--workers", type=int, help="of the cluster that is started here [default: one a core]")
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("tune", add_help=False, help="what python -m sil_host.tune takes, a trial a worker at once")
    study = commands.add_parser("montecarlo", help="what sil montecarlo flies, with the same rows")
    study.add_argument("--model", help="model file with tolerances [default: the F450 on the gimbal]")
    study.add_argument("--controller", action="append", metavar="pid|mpc|C.toml", help="may be given several times")
    study.add_argument("--controller-model", help="what the controllers take the vehicle for [default: the model]")
    study.add_argument("--script", help="fly this instead of the test sequence")
    study.add_argument("--runs", type=int, default=1000)
    study.add_argument("--seed", type=int, default=0)
    study.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/montecarlo.parquet"))
    study.add_argument("--quiet", action="store_true")
    return parser


def main(given: Sequence[str] | None = None) -> int:
    """The command."""
    options, rest = arguments().parse_known_args(given)
    try:
        if options.command == "tune":
            asked = tune.arguments().parse_args(rest)
            with cluster(options.address, options.workers) as workers:
                asked.jobs = workers
                return tune.run(asked, judge)
        if rest:
            arguments().error(f"unrecognized arguments: {' '.join(rest)}")
        return _montecarlo(options)
    except SilError as refused:
        print(f"error: {refused}", file=sys.stderr)
        return 2


def _montecarlo(options: argparse.Namespace) -> int:
    files = {"--model": options.model, "--controller-model": options.controller_model, "--script": options.script}
    study = Study(
        Model.load(options.model) if options.model else Model.nominal(),
        options.controller or ["pid", "mpc"],
        known=Model.load(options.controller_model) if options.controller_model else None,
        script=options.script,
        seed=options.seed,
        options="".join(f" {flag} {path}" for flag, path in files.items() if path),
    )
    options.out.parent.mkdir(parents=True, exist_ok=True)

    def told(done: int, of: int) -> None:
        if not options.quiet:
            print(f"\r{done} of {of} vehicles", end="", file=sys.stderr, flush=True)

    with cluster(options.address, options.workers) as workers:
        flown, found = montecarlo(study, options.runs, options.out, told)
    if not options.quiet:
        print(file=sys.stderr)
    print(f"{flown} vehicles flown by {workers} workers, {found} were there")
    print(f"rows    {options.out}")
    print(f"answer  sil montecarlo --summarise {options.out}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
