import json
from dataclasses import dataclass, replace

import cv2
import numpy as np
import pytest

from andante.baselines import MapMethod, make_methods
from andante.baselines.method import Learned
from andante.data import CameraSpec, Estimate, Hypothesis, Status
from andante.errors import LeakageError, LearningError, RecordingError
from andante.evaluation.compare import Comparison, Entry, compare
from andante.evaluation.compare_plots import error_distributions, error_maps
from andante.evaluation.compare_report import mapped_positions, remarks, render_comparison, write_comparison
from andante.evaluation.compare_tables import COST_COLUMNS, ERROR_COLUMNS, tables_of
from andante.evaluation.hardware import Hardware
from andante.evaluation.staged import answers_of
from andante.recordings import MemoryRecording


@dataclass(frozen=True)
class Same:
    """Says (1, 2) of every image; nothing of the first ``silent`` ones that it is asked."""

    name: str = "same"
    silent: int = 0
    heard: tuple = ()

    def prepare(self, image):
        return image.shape

    def locate(self, prepared):
        assert prepared == (12, 64)
        if self.silent:
            return Estimate(Status.LOST, "does not know")
        return Estimate(Status.OK, "", 1.0, 2.0, hypotheses=(Hypothesis(1.0, 2.0, 1.0),))

    def localize(self, image):
        return self.locate(self.prepare(image))

    def learn(self, recordings, *, positions="reference", progress=None):
        progress("thinking", 1, 2)
        return Learned(self, 1.5, 20.0, 3000, ("hard to say",))


@dataclass(frozen=True)
class Failing:
    name: str = "failing"

    def learn(self, recordings, *, positions="reference", progress=None):
        raise LearningError("nothing stands still; drive slower")


@pytest.fixture(scope="module")
def comparison(make_drive, make_ride) -> Comparison:
    methods = [*make_methods(["andante", "nearest-1"]), Same(), Same("silent", silent=1), Failing()]
    tests = [make_drive(2, name="walk"), make_ride(3, n=40, name="ride")]
    return compare([make_drive(1)], tests, methods)


def test_every_method_on_every_test(comparison):
    assert [one.name for one in comparison.entries] == ["andante", "nearest-1", "same", "silent", "failing"]
    same = comparison.entries[2]
    for test in comparison.tests:
        wanted = [np.hypot(1 - info.reference.x_m, 2 - info.reference.y_m) for info in test.infos]
        assert np.allclose(same.tests[test.name].errors, wanted)
        assert same.tests[test.name].seconds.shape == (40, 3)
        assert (same.tests[test.name].seconds > 0).all()
    assert comparison.entries[1].tests["walk"].figures().median_m < 0.5
    assert (same.learning_s, same.bytes, same.notes) == (21.5, 3000, ("hard to say",))


def test_failures_are_rows_with_a_reason(comparison):
    failed = comparison.entries[-1]
    assert failed.failure == "nothing stands still; drive slower"
    assert failed.learning_s is None
    assert "failing failed: nothing stands still; drive slower" in remarks(comparison)
    assert "same: hard to say" in remarks(comparison)


def test_only_andante_is_followed_and_only_where_there_is_odometry(comparison):
    assert [sorted(one.followed) for one in comparison.entries] == [["ride"], [], [], [], []]
    followed = comparison.entries[0].followed["ride"].figures()
    assert followed.n == 40
    assert followed.ms_per_image is None


def test_tables(comparison):
    walk, ride, followed, costs = tables_of(comparison)
    assert (walk.title, ride.title) == ("walk: 40 images", "ride: 40 images")
    assert walk.columns == ERROR_COLUMNS
    assert [row[0] for row in walk.rows] == ["andante", "nearest-1", "same", "silent", "failing (failed)"]
    assert all(len(row) == len(table.columns) for table in (walk, ride, followed, costs) for row in table.rows)
    row = dict(zip(ERROR_COLUMNS, walk.rows[3], strict=True))
    assert (row["median [m]"], row["mean [m]"], row["> 3 m [%]"], row["no answer [%]"]) == (None, None, 100, 100)
    assert walk.verdict.endswith("mean and max leave out what has no answer: silent 100.0 %")
    assert "than andante" in walk.verdict
    assert [row[0] for row in followed.rows] == ["ride: andante + tracker", "ride: andante, single images"]
    assert costs.columns == COST_COLUMNS
    row = dict(zip(COST_COLUMNS, costs.rows[2], strict=True))
    assert (row["preprocessing [s]"], row["mapping [s]"], row["size [kB]"]) == (1.5, 20.0, 3)
    assert "is smaller: 3 against" in costs.verdict
    assert (costs.rows[0][3], costs.rows[0][7]) == ("1", "1")


def test_plain_values(comparison):
    values = json.loads(json.dumps(comparison.as_dict(), allow_nan=False))
    assert values["mapped"] == ["drive 1"]
    assert values["tests"] == ["walk", "ride"]
    assert values["methods"]["failing"]["failure"].startswith("nothing stands still")
    assert set(values["methods"]["same"]["tests"]["walk"]) >= {"n", "median_m", "q75_m", "max_m", "share_over_3m"}
    assert {*values["hardware"]} == {"cpu", "cores", "platform"}


def test_entries_are_kept_and_read_again(comparison):
    for entry in comparison.entries:
        again = Entry.restored(json.loads(json.dumps(entry.stored(), allow_nan=False)))
        assert (again.name, again.failure, again.bytes) == (entry.name, entry.failure, entry.bytes)
        assert (again.learning_s, again.notes) == (entry.learning_s, entry.notes)
        for kept, told in ((again.tests, entry.tests), (again.followed, entry.followed)):
            assert list(kept) == list(told)
            for name, answers in told.items():
                assert np.allclose(kept[name].errors, answers.errors, atol=1e-5, equal_nan=True)
                assert np.allclose(kept[name].seconds, answers.seconds, atol=1e-6, equal_nan=True)


def test_report(comparison, page_of, tmp_path):
    page = page_of(render_comparison(comparison))
    assert "script" not in page.tags
    assert sum(source.startswith("data:image/svg") for source in page.sources) == 3
    path = write_comparison(comparison, tmp_path / "new")
    text = path.read_text(encoding="utf-8")
    for said in ("failing (failed)", "drive slower", str(Hardware.here()), "than andante"):
        assert said in text


def test_plots(comparison):
    told = {one.name: one.tests["walk"] for one in comparison.entries if one.failure is None}
    figure = error_maps(told, mapped_positions(comparison))
    titles = [axes.get_title() for axes in figure.axes if axes.get_title()]
    assert [title.split("\n")[0] for title in titles] == list(told)
    assert titles[3].endswith("no median, 100.0 % > 3 m")
    lines = error_distributions({"walk": told}).axes[0].get_lines()
    shares = {line.get_label(): line.get_ydata() for line in lines}
    assert shares["same"][-1] == 1
    assert len(shares["silent"]) == 0


def test_odometry_alone_is_laid_over_the_truth(make_ride):
    rides = [make_ride(seed, name=f"ride {seed}") for seed in (1, 2)]
    comparison = compare(rides[:1], rides[1:], [MapMethod()], positions="odometry")
    (entry,) = comparison.entries
    assert entry.failure is None
    assert entry.tests["ride 2"].figures().median_m < 0.6
    assert "laid over the truth" in entry.notes[-1]
    assert "the closer half of the answers themselves" in entry.notes[-1]


def test_leakage(make_drive):
    mapped = make_drive(1)
    with pytest.raises(LeakageError, match="'drive 1' is 'drive 1' itself, which the methods learn from"):
        compare([mapped], [mapped], [Same()])
    part = MemoryRecording(
        [mapped.load(info) for info in mapped.infos[:10]],
        np.arange(10) * 1.0,
        mapped.camera,
        reference=[info.reference for info in mapped.infos[:10]],
        name="part",
    )
    with pytest.raises(LeakageError, match="'part' has 100% of its pictures in common"):
        compare([mapped], [part], [Same()])


def test_what_cannot_be_compared(make_drive):
    mapped, test = make_drive(1), make_drive(2)
    with pytest.raises(RecordingError, match="drives to test on, got 1 and 0"):
        compare([mapped], [], [Same()])
    with pytest.raises(RecordingError, match="'drive 3' has no reference poses"):
        compare([mapped], [make_drive(3, truth=0)], [Same()])
    with pytest.raises(RecordingError, match="'drive 1' has no odometry positions"):
        compare([mapped], [test], [Same()], positions="odometry")
    with pytest.raises(RecordingError, match="two test recordings are called 'drive 2'"):
        compare([mapped], [test, make_drive(2, n=39)], [Same()])
    other = make_drive(2)
    other.camera = replace(CameraSpec(model="panorama"), forward_deg=90.0)
    with pytest.raises(RecordingError, match="taken by another camera"):
        compare([mapped], [other], [Same()])
    with pytest.raises(LearningError, match="no method could be compared: failing: nothing stands still"):
        compare([mapped], [test], [Failing()])


def test_progress_names_the_method(make_drive):
    told = []
    compare([make_drive(1)], [make_drive(2)], [Same()], progress=lambda *step: told.append(step))
    assert told[0] == ("same: thinking", 1, 2)
    assert told[-1] == ("same: drive 2", 40, 40)


def test_images_are_localized_in_one_thread(make_drive):
    threads = cv2.getNumThreads()
    seen = []

    class Asking(Same):
        def prepare(self, image):
            seen.append(cv2.getNumThreads())
            return image.shape

    answers_of(Asking(), make_drive(2))
    assert {*seen} == {1}
    assert cv2.getNumThreads() == threads


def test_unreadable_images(make_drive):
    from andante.errors import ImageError

    drive = make_drive(2)
    load, bad = drive.load, {3}

    def partly(info, *, colour=False):
        if info.index in bad:
            raise ImageError("damaged")
        return load(info, colour=colour)

    drive.load = partly
    assert len(answers_of(Same(), drive).errors) == 39
    bad |= {4, 5, 6}
    with pytest.raises(RecordingError, match="4 of 40 images cannot be used, the first one because: damaged"):
        answers_of(Same(), drive)


def test_hardware():
    text = str(Hardware("Some CPU", 1, "Linux x86_64"))
    assert text == "Some CPU, 1 core, Linux x86_64, no GPU used"
    assert Hardware.here().cores >= 1
