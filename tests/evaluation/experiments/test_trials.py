from dataclasses import replace

import numpy as np
import pytest

from andante.evaluation.experiments import trials
from andante.evaluation.experiments.contenders import ANDANTE, NEAREST, Contender, Fitted
from andante.evaluation.experiments.plans import STATIC, UNSEEN
from andante.evaluation.experiments.trials import Bench, Drive, Trial
from andante.mapping import MapConfig

SHARES = (0.9, 0.8, 0.7)


class Counting:
    """A localizer that answers with the mean position, and knows how often it learnt."""

    def __init__(self, interrupted_at=None):
        self.learnt = []
        self.interrupted_at = interrupted_at

    def __call__(self, front_end, drives, config):
        if len(self.learnt) == self.interrupted_at:
            raise KeyboardInterrupt
        self.learnt.append([len(drive.xy) for drive in drives])
        mean = np.concatenate([drive.xy for drive in drives]).mean(axis=0)
        return Fitted(lambda drive: np.tile(mean, (len(drive.xy), 1)), 16)


def trials_of(fit, config=None):
    contender = Contender("mean", config or MapConfig(), fit)
    parts = [tuple(range(int(70 * share))) for share in SHARES]
    return [Trial(contender, (Drive(STATIC, part),), Drive(UNSEEN)) for part in parts]


def test_estimates_and_truth(cache, singles):
    fit = Counting()
    found = Bench(singles, cache).run(trials_of(fit))
    assert fit.learnt == [[63], [56], [49]]
    garden = trials.rendered(singles, cache)[UNSEEN]
    truth = np.array([(info.reference.x_m, info.reference.y_m) for info in garden.infos])
    for result in found:
        np.testing.assert_allclose(result.truth, truth, atol=1e-4)
        np.testing.assert_allclose(result.errors, np.linalg.norm(result.xy - result.truth, axis=1))
        assert result.bytes == 16


def test_a_killed_run_goes_on_and_gives_the_same(cache, singles, tmp_path, pictures):
    whole = Bench(singles, pictures).run(trials_of(Counting()))
    with pytest.raises(KeyboardInterrupt):
        Bench(singles, cache).run(trials_of(Counting(interrupted_at=2)))
    rest = Counting()
    found = Bench(singles, cache).run(trials_of(rest))
    assert rest.learnt == [[49]]
    for one, other in zip(found, whole, strict=True):
        np.testing.assert_array_equal(one.xy, other.xy)
        np.testing.assert_array_equal(one.truth, other.truth)


def test_what_is_finished_needs_no_pictures(cache, singles, monkeypatch):
    bench = Bench(singles, cache)
    bench.run(trials_of(Counting()))
    monkeypatch.setattr(trials, "rendered", None)
    Bench(singles, cache).run(trials_of(Counting(interrupted_at=0)))


@pytest.mark.parametrize("change", ["configuration", "name", "detail", "code", "pictures", "frames"])
def test_what_changed_is_done_again(cache, singles, monkeypatch, change):
    Bench(singles, cache).run(trials_of(Counting())[:1])
    fit = Counting()
    (trial,) = trials_of(fit, MapConfig(seed=1) if change == "configuration" else None)[:1]
    if change == "name":
        trial = replace(trial, contender=replace(trial.contender, name="average"))
    if change == "detail":
        trial = replace(trial, contender=replace(trial.contender, detail=(1,)))
    if change == "code":
        monkeypatch.setattr(trials, "code_hash", lambda: "other")
    if change == "frames":
        trial = replace(trial, test=Drive(UNSEEN, (3, 5)))
    if change == "pictures":
        sessions = [
            session.model_copy(update={"conditions": session.conditions.model_copy(update={"noise": 5.0})})
            if session.name == UNSEEN
            else session
            for session in singles.sessions
        ]
        singles = singles.model_copy(update={"sessions": tuple(sessions)})
    (result,) = Bench(singles, cache).run([trial])
    assert fit.learnt == [[63]]
    assert len(result.xy) == (2 if change == "frames" else 70)


def test_drives_are_encoded_once_for_localizers_that_share_their_features(cache, singles, monkeypatch):
    read = []
    real = trials.encode
    monkeypatch.setattr(
        trials, "encode", lambda recording, *rest: read.append(recording.name) or real(recording, *rest)
    )
    runs = [Trial(contender, (Drive(STATIC),), Drive(UNSEEN)) for contender in (ANDANTE, *NEAREST)]
    told = []
    Bench(singles, cache, progress=lambda stage, done, total: told.append((stage, done, total))).run(runs)
    assert sorted(read) == [STATIC, UNSEEN]
    assert (f"read {STATIC}", 70, 70) in told
    assert told[-1] == ("trials", 3, 3)


def test_a_map_says_what_it_says_by_itself(cache, singles):
    """The batch behind an experiment against one image after the other."""
    from andante.mapping import build_map

    (result,) = Bench(singles, cache).run([Trial(ANDANTE, (Drive(STATIC),), Drive(UNSEEN))])
    recordings = trials.rendered(singles, cache)
    slowmap = build_map([recordings[STATIC]])
    for at in (0, 13, 69):
        picture = recordings[UNSEEN].load(recordings[UNSEEN].infos[at])
        best = slowmap.localize(picture).hypotheses[0]
        np.testing.assert_allclose(result.xy[at], (best.x_m, best.y_m), atol=2e-3)


def test_tasks_keep_their_order_in_any_number_of_processes(years, tmp_path):
    tasks = list(range(-20, 20))
    for workers in (1, 2):
        assert list(Bench(years, tmp_path, workers=workers).spread(abs, tasks)) == [abs(one) for one in tasks]
