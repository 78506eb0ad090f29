"""All experiments by name."""

from __future__ import annotations

from functools import partial

from andante.errors import InputError
from andante.evaluation.experiments.comparison import run_comparison
from andante.evaluation.experiments.comparison_world import MAPPED_FRAMES, comparison_plan
from andante.evaluation.experiments.gaze import run_gaze
from andante.evaluation.experiments.landmark_world import small_plan
from andante.evaluation.experiments.landmarks import run_landmarks
from andante.evaluation.experiments.long_term import run_long_term
from andante.evaluation.experiments.navigation import run_navigation
from andante.evaluation.experiments.navigation_world import navigation_plan
from andante.evaluation.experiments.off_map import run_off_map
from andante.evaluation.experiments.outcome import Experiment
from andante.evaluation.experiments.plans import COW, GROWING, STATIC, UNSEEN, Scale, long_term_plan, single_plan
from andante.evaluation.experiments.single import run_dynamic_object, run_slow_light, run_static
from andante.evaluation.experiments.stress import run_stress
from andante.evaluation.experiments.tracking import run_tracking

DEFAULT_SEED = 23
"""Of a garden on which nothing in this package was chosen."""

_SMALL, _FULL = Scale(frames=200, image_px=320), Scale(frames=279, image_px=480)
_SMALL_YEARS = Scale(frames=150, image_px=240, sessions=6, permutations=3, runs=10)
_FULL_YEARS = Scale(frames=297, image_px=480, sessions=10, permutations=15, runs=100)

EXPERIMENTS = (
    Experiment(
        name="static",
        title="One recording in static light",
        source="6.3.1, figure 6.4",
        thesis="mean 0.08 m, slow features having seen the test images",
        plan=partial(single_plan, names=(STATIC,)),
        run=run_static,
        small=_SMALL,
        full=_FULL,
    ),
    Experiment(
        name="slow-light",
        title="Light that grows slowly while the robot maps",
        source="6.3.1, figures 6.6 and 6.7",
        thesis="mean 1.41 m; 0.17 m when joined with a static recording",
        plan=partial(single_plan, names=(STATIC, GROWING, UNSEEN)),
        run=run_slow_light,
        small=_SMALL,
        full=_FULL,
    ),
    Experiment(
        name="dynamic-object",
        title="A cow that was not mapped",
        source="6.3.1, figure 6.9",
        thesis="mean 0.12 m",
        plan=partial(single_plan, names=(STATIC, UNSEEN, COW)),
        run=run_dynamic_object,
        small=_SMALL,
        full=_FULL,
    ),
    Experiment(
        name="long-term",
        title="More and more sessions mapped, the next one localized",
        source="6.3.1, figures 6.10 and 6.11",
        thesis="mean 0.4 m (Fourier) and 0.5 m (raw images) with nine sessions",
        plan=long_term_plan,
        run=run_long_term,
        small=Scale(frames=150, image_px=240, sessions=6, permutations=5),
        full=Scale(frames=297, image_px=480, sessions=10, permutations=15),
    ),
    Experiment(
        name="tracking",
        title="Unseen sessions followed with odometry that drifts",
        source="8 and 10.1",
        thesis="a preliminary Kalman filter whose error was 30 % smaller than that of single images",
        plan=long_term_plan,
        run=run_tracking,
        small=_SMALL_YEARS,
        full=_FULL_YEARS,
    ),
    Experiment(
        name="stress",
        title="Trackers under everything that goes wrong",
        source="10.1",
        thesis="nothing of this was tried",
        plan=long_term_plan,
        run=run_stress,
        small=_SMALL_YEARS,
        full=_FULL_YEARS,
    ),
    Experiment(
        name="off-map",
        title="Images of mapped places, and of everything else",
        source="10.1",
        thesis="nothing of this was tried",
        plan=long_term_plan,
        run=run_off_map,
        small=_SMALL_YEARS,
        full=_FULL_YEARS,
    ),
    Experiment(
        name="gaze",
        title="Position from any patch of an image",
        source="7.6, figures 7.13 to 7.16",
        thesis="median 0.17 m with three patches",
        plan=long_term_plan,
        run=run_gaze,
        small=Scale(frames=150, image_px=240, sessions=4, permutations=2),
        full=Scale(frames=297, image_px=480, sessions=10, permutations=5),
    ),
    Experiment(
        name="navigation",
        title="Down the slope of slow features",
        source="9.4, figures 9.1 to 9.6",
        thesis="85 % within 0.8 m in the open, 70 % around the obstacle",
        plan=navigation_plan,
        run=run_navigation,
        small=Scale(frames=3000, image_px=300, errands=8, repeats=1),
        full=Scale(frames=15_000, image_px=300, errands=200, repeats=5),
    ),
    Experiment(
        name="comparison",
        title="Slow features against structure and networks",
        source="8.3",
        thesis="median 0.48 m on the mapped path, 0.72 m off it",
        plan=comparison_plan,
        run=run_comparison,
        small=Scale(frames=284, image_px=480),
        full=Scale(frames=MAPPED_FRAMES, image_px=480),
    ),
    Experiment(
        name="landmarks",
        title="Landmarks, one by one and together",
        source="7.4, tables 7.1 and 7.3",
        thesis="median 0.16 m; 2.22 and 2.57 m in a large garden",
        plan=small_plan,
        run=run_landmarks,
        small=Scale(frames=300, image_px=320, permutations=10),
        full=Scale(frames=2000, image_px=480, permutations=50, detector="learnt"),
    ),
)


def experiment_named(name: str) -> Experiment:
    """An experiment by name; raises ``InputError`` for an unknown one."""
    for experiment in EXPERIMENTS:
        if experiment.name == name:
            return experiment
    known = ", ".join(experiment.name for experiment in EXPERIMENTS)
    raise InputError(f"there is no experiment {name!r}; choose one of {known}")
