import dataclasses

import pytest

torch = pytest.importorskip("torch", reason="the extra torch is not installed")

from andante.baselines.posenet import Schedule  # noqa: E402
from andante.baselines.posenet.augmentation import Augmentation  # noqa: E402
from andante.baselines.posenet.network import PoseNetwork  # noqa: E402
from andante.baselines.posenet.training import Views, median_error, threads_and_seed, train  # noqa: E402
from andante.errors import ConfigError  # noqa: E402

SHAPE = (8, 64)
NOTHING = Augmentation(turn=False, contrast=0, brightness=0, noise=0, hidden=0, clouds=0)
QUICK = Schedule(steps=60, batch_size=8, validate_every=10, patience=15, threads=1)


@pytest.fixture(scope="module")
def eight():
    chance = torch.Generator().manual_seed(0)
    turn = torch.arange(8) * torch.pi / 4
    pictures = torch.randn(8, 1, *SHAPE, generator=chance)
    return Views(pictures, torch.stack([turn.cos(), turn.sin()], 1), turn)


def learn(views, schedule=QUICK, augmentation=NOTHING):
    seen = []
    with threads_and_seed(schedule.threads, schedule.seed) as generator:
        network = PoseNetwork(SHAPE, wrap=True, channels=8)
        course = train(
            network, views, views, augmentation, schedule, generator=generator, progress=lambda *step: seen.append(step)
        )
    return network, course, seen


def test_a_tiny_network_learns_eight_pictures_by_heart(eight):
    network, course, seen = learn(eight)
    assert course.validation < 0.1
    assert median_error(network, eight) == course.validation
    assert seen[-1] == (course.steps, 60)
    with torch.inference_mode():
        _, heading = network.eval()(eight.panoramas)
    off = torch.atan2(heading[:, 1], heading[:, 0]) - eight.heading
    assert off.cos().min() > 0.97


def test_the_seed_decides_and_the_world_outside_is_left_alone(eight):
    schedule = dataclasses.replace(QUICK, steps=6, validate_every=3)
    before, threads = torch.random.get_rng_state(), torch.get_num_threads()
    first, again = (learn(eight, schedule, Augmentation(turn=True))[0].state_dict() for _ in range(2))
    other = learn(eight, dataclasses.replace(schedule, seed=1), Augmentation(turn=True))[0].state_dict()
    assert all(torch.equal(first[name], again[name]) for name in first)
    assert not all(torch.equal(first[name], other[name]) for name in first)
    assert torch.equal(torch.random.get_rng_state(), before)
    assert torch.get_num_threads() == threads


def test_it_ends_when_time_is_up_or_nothing_gets_better(eight):
    _, course, _ = learn(eight, dataclasses.replace(QUICK, max_seconds=1e-9))
    assert (course.steps, course.end) == (0, "no more in the budget of 1e-09 s")
    _, course, _ = learn(eight, dataclasses.replace(QUICK, learning_rate=1e-30, validate_every=1, patience=3))
    assert (course.steps, course.end) == (4, "stopped as 3 validations brought nothing better")


def test_the_best_weights_are_kept(eight):
    # At a rate this high the network gets worse again before it ends.
    wild = dataclasses.replace(QUICK, steps=20, validate_every=1, learning_rate=0.03, patience=20)
    network, course, _ = learn(eight, wild)
    assert median_error(network, eight) == course.validation


def test_a_schedule_that_cannot_be_is_refused():
    with pytest.raises(ConfigError, match=r"steps of a schedule must be at least 1, got 0"):
        Schedule(steps=0)
    with pytest.raises(ConfigError, match=r"learning_rate of a schedule must be positive, got nan"):
        Schedule(learning_rate=float("nan"))
