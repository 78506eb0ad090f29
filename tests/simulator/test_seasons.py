import numpy as np
import pytest

from andante.data import Pose2D
from andante.simulator import Conditions, Renderer, SimulatedCamera
from andante.simulator.mesh import Matter
from andante.simulator.seasons import SEASONS, dressed

POSE = Pose2D(2.5, -2.5, 0.3)


@pytest.mark.parametrize("season", SEASONS)
def test_a_season_takes_leaves_and_blossoms_and_moves_nothing(scene, season):
    worn = dressed(scene, season)
    falling = (Matter.LEAF, Matter.BLOSSOM)
    firm_before, firm_after = (~np.isin(s.mesh.matter, falling) for s in (scene, worn))
    np.testing.assert_array_equal(worn.mesh.corners[firm_after], scene.mesh.corners[firm_before])
    np.testing.assert_array_equal(worn.object_id[firm_after], scene.object_id[firm_before])
    there = {row.tobytes() for row in scene.mesh.corners[~firm_before]}
    assert all(row.tobytes() in there for row in worn.mesh.corners[~firm_after])


def test_leaves_are_fewer_from_summer_over_autumn_to_winter(scene):
    leaves = {season: int((dressed(scene, season).mesh.matter == Matter.LEAF).sum()) for season in SEASONS}
    assert leaves["summer"] > leaves["autumn"] > leaves["spring"] > leaves["winter"] == 0


def test_snow_whitens_ground_roofs_and_part_of_the_evergreens(scene):
    winter = dressed(scene, "winter").mesh
    white = winter.colour.min(axis=1) > 0.7
    assert white[winter.matter == Matter.GROUND].all()
    assert 0.05 < white[winter.matter == Matter.NEEDLE].mean() < 0.7
    summer = dressed(scene, "summer").mesh
    assert summer.colour[summer.matter == Matter.GROUND].max() < 0.7


def test_dressing_leaves_the_scene_as_it_was(scene):
    before = scene.mesh.colour.copy()
    dressed(scene, "winter")
    np.testing.assert_array_equal(scene.mesh.colour, before)


def test_object_ids_agree_between_seasons_except_where_leaves_are(embree, scene):
    camera = SimulatedCamera(model="panorama", width_px=160, height_px=48)
    ids = {s: Renderer(scene, Conditions(season=s), camera).render(POSE).object_id for s in ("summer", "winter")}
    leafy = [n for n, name in enumerate(scene.names) if name.startswith(("tree", "bush", "pot"))]
    behind_leaves = np.isin(ids["summer"], leafy)
    np.testing.assert_array_equal(ids["winter"][~behind_leaves], ids["summer"][~behind_leaves])
    assert (ids["winter"] != ids["summer"]).any()
