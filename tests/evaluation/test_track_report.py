import re
from dataclasses import replace

import pytest

from andante.data import Estimate, FrameInfo, Status
from andante.errors import InputError
from andante.evaluation import LocalizedFrame, Run, track, write_track_report
from andante.evaluation.track_report import status_changes

HOSTILE = "<script>alert('$x^2$')</script> & \"garden\""


@pytest.fixture(scope="module")
def tracked(slowmap, make_ride):
    return track(slowmap, make_ride(3, name=HOSTILE, conditions={"weather": HOSTILE}))


@pytest.fixture(scope="module")
def text(tracked, slowmap, tmp_path_factory):
    folder = tmp_path_factory.mktemp("report") / "new" / "folder"
    page = write_track_report(tracked, folder, replace(slowmap, name=HOSTILE))
    assert page.name == "report.html"
    return page.read_text(encoding="utf-8")


def test_the_page_is_whole_and_needs_nothing_else(text, page_of):
    page = page_of(text)
    assert page.tags.isdisjoint({"script", "link", "iframe"})
    assert all(source.startswith("data:image/svg") for source in page.sources)
    assert len(page.sources) == 5
    assert "http://" not in re.sub(r'src="[^"]*"', "", text)


def test_text_of_others_is_escaped(text):
    assert "<script" not in text
    assert "&lt;script&gt;alert(&#39;$x^2$&#39;)&lt;/script&gt; &amp; &#34;garden&#34;" in text


def test_it_tells_both_and_when_the_status_changed(text, tracked):
    assert '<th class="number">particles</th><th class="number">single images</th>' in text
    assert "median heading error, °" in text
    assert text.count('class="reason"') == len(status_changes(tracked.run))


def test_without_truth_or_pictures_it_is_shorter(slowmap, make_ride, page_of, tmp_path):
    done = track(slowmap, make_ride(3, truth=False, odometry=False))
    text = write_track_report(done, tmp_path, slowmap).read_text(encoding="utf-8")
    assert len(page_of(text).sources) == 2
    assert "no reference poses, so there are no errors to tell" in text
    assert "tracked by images alone" in text


def test_changes_of_status():
    said = [Status.LOST, Status.LOST, Status.OK, Status.OK, Status.LOST]
    frames = (LocalizedFrame(FrameInfo(n, f"{n}", 5.0 + n), Estimate(one, one), 0.0) for n, one in enumerate(said))
    changes = status_changes(Run(tuple(frames)))
    assert [(one["image"], one["time"], one["status"]) for one in changes] == [
        ("0", "0.0", "lost"), ("2", "2.0", "ok"), ("4", "4.0", "lost"),
    ]  # fmt: skip
    assert status_changes(Run(())) == []


def test_a_file_is_no_place_for_it(tracked, slowmap, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"report folder .*file cannot be made"):
        write_track_report(tracked, tmp_path / "file", slowmap)
