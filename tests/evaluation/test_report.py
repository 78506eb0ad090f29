import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from andante.data import CameraSpec
from andante.errors import InputError
from andante.evaluation import evaluate, write_report
from andante.mapping import build_map

HOSTILE = "<script>alert('$x^2$')</script> & \"garden\""


@pytest.fixture(scope="module")
def compared(slowmap, make_drive):
    test = make_drive(3, blank=(6,), truth=0.9, name=HOSTILE, conditions={"weather": HOSTILE})
    training = [make_drive(1), make_drive(2)]
    return evaluate(replace(slowmap, name=HOSTILE), test, baselines=True, training=training)


@pytest.fixture(scope="module")
def text(compared, slowmap, tmp_path_factory):
    page = write_report(compared, tmp_path_factory.mktemp("report") / "new" / "folder", replace(slowmap, name=HOSTILE))
    assert page.name == "report.html"
    return page.read_text(encoding="utf-8")


def test_the_page_is_whole_and_needs_nothing_else(text, page_of):
    page = page_of(text)
    assert page.tags.isdisjoint({"script", "link", "iframe"})
    assert all(source.startswith("data:image/") for source in page.sources)
    assert "http://" not in re.sub(r'src="[^"]*"', "", text)


def test_it_shows_plots_worst_frames_and_the_table(text, compared, page_of):
    page = page_of(text)
    assert sum(source.startswith("data:image/svg") for source in page.sources) == 4
    assert sum(source.startswith("data:image/jpeg") for source in page.sources) == 10
    assert all(f">{name}<" in text for name in compared.baselines)
    assert compared.verdict in text
    assert "1 pictures show nothing" in text
    assert "36 frames with truth of 40" in text


def test_headings_are_shown_where_the_map_knows_some(compared, slowmap, tmp_path, text):
    assert "heading error" not in text
    headed = replace(compared.map, figures=replace(compared.figures, heading_median_deg=1.26))
    page = write_report(replace(compared, map=headed), tmp_path, slowmap).read_text(encoding="utf-8")
    row = page.split("median heading error, °</th>")[1].split("</tr>")[0]
    assert re.findall(r">([^<]+)</td>", row) == ["1.3", *"–" * len(compared.baselines)]


def test_text_of_others_is_escaped(text):
    assert "<script" not in text
    assert "&lt;script&gt;alert(&#39;$x^2$&#39;)&lt;/script&gt; &amp; &#34;garden&#34;" in text


def test_the_same_evaluation_gives_the_same_page(text, compared, slowmap, tmp_path):
    again = write_report(compared, tmp_path, replace(slowmap, name=HOSTILE)).read_text(encoding="utf-8")
    assert again == text


def test_notes_and_places(place_map, make_drive, tmp_path, page_of):
    evaluation = evaluate(place_map, make_drive(2, places=True), training_error=True)
    text = write_report(evaluation, tmp_path, place_map).read_text(encoding="utf-8")
    page_of(text)
    assert "training error" in text
    assert "median error, places" in text
    assert "Predicted radius" not in text


def test_a_map_without_references_and_frames_without_errors(make_drive, slowmap, tmp_path, page_of):
    config = slowmap.config.with_values({"readout": {"kind": "polynomial", "inputs": 2}})
    polynomial = build_map([make_drive(1)], config)
    drive = make_drive(3, blank=tuple(range(40)))
    evaluation = evaluate(polynomial, drive)
    assert evaluation.figures.n_errors == 0
    page_of(write_report(evaluation, tmp_path, polynomial).read_text(encoding="utf-8"))


def test_pictures_of_another_camera_are_shown_as_the_map_saw_them(slowmap, make_drive, tmp_path):
    drive = make_drive(3)
    drive._images = tuple(np.repeat(image, 2, axis=0).repeat(2, axis=1) for image in drive._images)
    drive.camera = CameraSpec(model="panorama", forward_deg=90.0)
    page = write_report(evaluate(slowmap, drive), tmp_path, slowmap)
    assert page.read_text(encoding="utf-8").count("data:image/jpeg") == 10


def test_a_folder_that_cannot_be_made_is_one_line(compared, slowmap, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"report folder .* cannot be made: .*; choose another place"):
        write_report(compared, tmp_path / "file", slowmap)


def test_plots_are_loaded_only_for_a_report():
    code = "import sys, andante.evaluation; sys.exit(bool({'matplotlib', 'jinja2'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
