"""A study and a search on a local Ray cluster of two workers, one of which is killed while it flies."""

import os
import pathlib
import pickle
import signal
import subprocess
import threading
import time

import pytest

import sil_host as sil

pytest.importorskip("ray")
pytest.importorskip("optuna")

from sil_host import cluster, tune  # noqa: E402  after the skips

SIL = os.environ.get("SIL")
RUNS = 600
#: Long enough that a part of 200 flights takes seconds.
SCRIPT = "duration_s = 6.0\n[[step]]\nat_s = 0.5\nroll_deg = 20\n"


def workers_that_fly():
    """Process numbers of Ray's workers that hold a part: Ray names a process after its task."""
    for entry in pathlib.Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                if (entry / "cmdline").read_bytes().startswith(b"ray::_rows_of_part"):
                    yield int(entry.name)
            except OSError:
                pass  # it has ended meanwhile


def test_a_study_and_a_model_go_to_other_processes():
    study = pickle.loads(pickle.dumps(sil.Study(sil.Model.nominal(), ["pid"], script=SCRIPT, seed=5)))
    assert isinstance(study, sil.Study)
    model = sil.Model.nominal("free").with_effects(["weak_motor:motor=2,scale=0.9"])
    assert pickle.loads(pickle.dumps(model)).to_toml() == model.to_toml()


@pytest.mark.skipif(SIL is None, reason="SIL names the binary to compare with")
def test_a_killed_worker_loses_nothing_and_the_file_is_that_of_sil_montecarlo(tmp_path):
    script, out = tmp_path / "s.toml", tmp_path / "cluster.parquet"
    script.write_text(SCRIPT)
    killed = []

    def kill_one():
        for _ in range(600):
            for process in workers_that_fly():
                time.sleep(0.3)  # in the middle of its part
                os.kill(process, signal.SIGKILL)
                killed.append(process)
                return
            time.sleep(0.05)

    killer = threading.Thread(target=kill_one)
    killer.start()
    given = ["--controller", "pid", "--script", str(script), "--runs", str(RUNS), "--seed", "3"]
    assert cluster.main(["--workers", "2", "montecarlo", *given, "--out", str(out), "--quiet"]) == 0
    killer.join()
    assert killed, "no worker was killed"
    alone = tmp_path / "alone.parquet"
    subprocess.run([SIL, "montecarlo", *given, "--out", str(alone), "--quiet"], check=True)
    assert out.read_bytes() == alone.read_bytes()


def test_what_is_there_is_not_flown_again(tmp_path):
    out = tmp_path / "rows.parquet"
    study = sil.Study(sil.Model.nominal(), ["pid"], script="duration_s = 0.5\n", seed=1)
    first, *rest = study.missing(RUNS, out)
    study.fly_part(first, study.path_of_part(first, out))
    assert study.missing(RUNS, out) == rest == [(200, 400), (400, 600)]
    with cluster.cluster(workers=2) as workers:
        assert workers == 2
        told = []
        assert cluster.montecarlo(study, RUNS, out, lambda done, of: told.append((done, of))) == (400, 200)
    assert told[0] == (200, RUNS) and told[-1] == (RUNS, RUNS)
    assert study.missing(RUNS, out) == []


def test_a_search_on_a_cluster_is_that_on_threads():
    task = tune.Task(sil.Model.nominal(), "pid", draws=1)
    given = (task, ["rms_deg", "noise"], [], 4)
    here = tune.search(*given, seed=2, jobs=2)
    with cluster.cluster(workers=2):
        there = tune.search(*given, seed=2, jobs=2, judge=cluster.judge)
    assert [trial.values for trial in there.trials] == [trial.values for trial in here.trials]


def test_what_cannot_be_is_refused(tmp_path, capsys):
    assert cluster.main(["montecarlo", "--model", str(tmp_path / "none.toml")]) == 2
    assert "none.toml" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        cluster.main(["montecarlo", "--vehicles", "3"])
    assert "--vehicles" in capsys.readouterr().err
