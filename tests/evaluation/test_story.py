"""The parts of a report on a simulated garden."""

import numpy as np
import pytest

from andante.data import Pose2D
from andante.evaluation import Picture, Section, SpatialMaps, evaluate, spatial_maps, write_report
from andante.evaluation.garden_plots import extent_m, feature_maps
from andante.evaluation.story import sections_of, view_of
from andante.evaluation.top_view import top_view
from andante.simulator import GardenSpec, Plan, Scene, Session, SimulatedCamera, make_garden


@pytest.fixture(scope="module")
def plan():
    pytest.importorskip("embreex", reason="rays need the extra sim: pip install 'andante[sim]'")
    drive = {"kind": "poses", "poses": [(0.0, 0.0, 0.0)]}
    sessions = tuple(
        Session(name=season, drive=drive, conditions={"season": season}) for season in ("summer", "winter")
    )
    camera = SimulatedCamera(width_px=64, height_px=64)
    return Plan(garden=GardenSpec(seed=3, size_x_m=10, size_y_m=10), camera=camera, sessions=sessions)


@pytest.fixture(scope="module")
def maps():
    x, y = np.meshgrid(np.arange(5.0), np.arange(4.0))
    xy = np.column_stack([x.ravel(), y.ravel()])
    return spatial_maps(xy, np.column_stack([xy, xy[:, 0] * xy[:, 1]]))


def test_from_above_things_are_where_their_footprints_are(plan):
    garden = make_garden(plan.garden)
    view = top_view(Scene.of(garden.things), 12.0, 10.0, pixels_per_m=10.0)
    assert view.image.shape == (100, 120, 3)
    assert view.extent_m == (-6.0, 6.0, -5.0, 5.0)
    fence = next(thing for thing in garden.things if thing.footprints)
    bare = top_view(Scene.of([thing for thing in garden.things if thing is not fence]), 12.0, 10.0, pixels_per_m=10.0)
    rows, columns = np.nonzero((view.image != bare.image).any(axis=2))
    x, y = -6.0 + (columns + 0.5) / 10, 5.0 - (rows + 0.5) / 10
    low, high = fence.mesh.corners[..., :2].min(axis=(0, 1)), fence.mesh.corners[..., :2].max(axis=(0, 1))
    assert len(x)
    assert (x >= low[0] - 0.1).all()
    assert (x <= high[0] + 0.1).all()
    assert (y >= low[1] - 0.1).all()
    assert (y <= high[1] + 0.1).all()


def test_one_place_looks_different_in_winter(plan):
    summer, winter = (view_of(plan, name, Pose2D(0.0, 0.0, 0.0)) for name in ("summer", "winter"))
    assert summer.shape == winter.shape == (160, 960, 3)
    assert winter[-20:].mean() > summer[-20:].mean() + 20  # snow on the ground


def test_feature_maps_have_one_plot_each(maps):
    figure = feature_maps(maps)
    assert [axes.get_title() for axes in figure.axes] == ["s1", "s2", "s3"]
    assert extent_m(maps) == (-0.5, 4.5, -0.5, 3.5)


def test_a_constant_feature_is_drawn_as_well():
    maps = SpatialMaps(np.zeros((1, 2, 2)), np.arange(2.0), np.arange(2.0))
    assert len(feature_maps(maps).axes) == 1


def test_the_report_tells_the_story(plan, maps, slowmap, make_drive, tmp_path):
    evaluation = evaluate(slowmap, make_drive(3))
    sections = sections_of(plan, ("summer", "winter"), evaluation, slowmap, maps)
    assert [len(section.pictures) for section in sections] == [2, 1, 1]
    assert "by 1.00 and 1.00" in sections[2].text
    text = write_report(evaluation, tmp_path, slowmap, sections).read_text(encoding="utf-8")
    assert text.count("data:image/jpeg") >= 2
    assert "http://" not in "".join(part.split('"')[0] for part in text.split('src="')[1:])


def test_what_a_section_says_is_text_not_markup(slowmap, make_drive, tmp_path):
    section = Section("<b>", "<i>", (Picture.of_svg("<u>", "<svg/>"),), (("<s>", "1", "2"),))
    text = write_report(evaluate(slowmap, make_drive(3)), tmp_path, slowmap, [section]).read_text(encoding="utf-8")
    for tag in ("b", "i", "u", "s"):
        assert f"&lt;{tag}&gt;" in text
        assert f"<{tag}>" not in text
    assert '<td class="number">1</td><td class="number">2</td>' in text
