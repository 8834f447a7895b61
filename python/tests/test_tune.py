"""The search over tunings, on few trials: what it keeps, what it repeats, what it says of the shipped tuning."""

import csv

import pytest

import sil_host as sil

optuna = pytest.importorskip("optuna")

from sil_host import tune  # noqa: E402  after the skip

OBJECTIVES = ["rms_deg", "push_deg", "noise"]


@pytest.fixture(scope="module")
def task():
    return tune.Task(sil.Model.nominal(), "pid", draws=1)


@pytest.fixture(scope="module")
def study(task):
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    return tune.search(task, OBJECTIVES, [tune.Limit("delay_margin_ms", 25.0, True)], 24, seed=3)


def test_a_trial_of_factor_one_is_the_shipped_tuning(task, study):
    shipped = study.trials[0]
    assert set(shipped.params.values()) == {1.0}
    figures = shipped.user_attrs["figures"]
    flights = [sil.fly(task.model, "pid", seed=1), sil.fly(task.model.draw(1, 0), "pid", known=task.model, seed=2)]
    overshoot = [flight.figures["axes"][axis]["overshoot_pct"] for flight in flights for axis in ("roll", "pitch")]
    assert figures["overshoot_pct"] == pytest.approx(sum(overshoot) / 4, rel=1e-6)
    margins = sil.margins(task.model, "pid")
    assert figures["delay_margin_ms"] == pytest.approx(min(axis["delay_ms"] for axis in margins), rel=1e-6)


def test_no_point_of_the_front_breaks_a_limit_or_is_worse_than_another(study):
    points = tune.front(study)
    assert len(points) >= 2
    assert all(point.user_attrs["figures"]["delay_margin_ms"] >= 25.0 for point in points)
    for one in points:
        assert not any(all(a < b for a, b in zip(other.values, one.values)) for other in points)
    broken = [trial for trial in study.trials if trial.user_attrs.get("figures", {}).get("delay_margin_ms", 99) < 25.0]
    assert broken, "the limit has to be one that trials break"


def test_the_shipped_tuning_is_held_against_the_front(study):
    share = tune.improved_by(study, study.trials[0])
    better = [
        point for point in tune.front(study) if all(a < b for a, b in zip(point.values, study.trials[0].values))
    ]
    assert (share > 0.0) == bool(better)
    assert all(tune.improved_by(study, point) == 0.0 for point in tune.front(study))


def test_a_search_comes_again_and_goes_on(task, study, tmp_path):
    again = tune.search(task, OBJECTIVES, [tune.Limit("delay_margin_ms", 25.0, True)], 6, seed=3)
    assert [trial.params for trial in again.trials] == [trial.params for trial in study.trials[:6]]
    storage = f"sqlite:///{tmp_path}/tune.db"
    for trials in (2, 4):
        kept = tune.search(task, OBJECTIVES, [], trials, seed=3, storage=storage)
        assert len(kept.trials) == trials


def test_the_command_writes_the_front_and_confirms_a_point_on_other_vehicles(tmp_path, capsys):
    given = ["--trials", "4", "--draws", "1", "--quiet", "--out", str(tmp_path), "--pick", "0", "--confirm", "2"]
    assert tune.main([*given, "--at-least", "delay_margin_ms=1"]) in (0, 2)
    told = capsys.readouterr()
    rows = list(csv.DictReader((tmp_path / "front.csv").open()))
    assert rows and all(float(row["delay_margin_ms"]) >= 1.0 for row in rows)
    for row in rows:
        file = tmp_path / f"trial-{row['trial']}.toml"
        assert sil.fly(sil.Model.nominal(), str(file)).figures["controller"] == "pid"
    assert "rms_deg" in (tmp_path / "front.html").read_text()
    on_front = any(row["trial"] == "0" for row in rows)
    assert ("that no trial saw" in told.out) == on_front and ("not on the front" in told.err) != on_front


def test_limits_that_cannot_be_are_refused(capsys):
    for given, told in [
        (["--at-least", "speed=3"], "expected FIGURE=VALUE"),
        (["--at-most", "noise=low"], "'low' is no number"),
        (["--controller", "lqr"], "invalid choice"),
    ]:
        with pytest.raises(SystemExit):
            tune.main(given)
        assert told in capsys.readouterr().err
    assert tune.main(["--model", "none.toml", "--quiet"]) == 2
