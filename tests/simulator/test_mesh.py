import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.simulator.mesh import Layer, Matter, Mesh, Paint
from andante.simulator.shapes import box, boxes, ellipsoid, leaves, prism, quads, rods

PAINT = Paint(0.1, 0.2, 0.3, Layer.WOOD, Matter.ROOF)
SQUARE = [[(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)]]


def area(mesh: Mesh) -> float:
    edges = mesh.corners[:, 1:] - mesh.corners[:, :1]
    return float(np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1).sum() / 2.0)


def test_a_quad_is_two_triangles_with_metric_texture_coordinates():
    mesh = quads(SQUARE, PAINT)
    assert len(mesh) == 2
    assert area(mesh) == pytest.approx(2.0)
    np.testing.assert_allclose(mesh.uv, mesh.corners[..., :2], atol=1e-6)
    assert set(mesh.layer) == {Layer.WOOD}
    assert set(mesh.matter) == {Matter.ROOF}


def test_areas_of_solids_are_those_of_geometry():
    assert area(box((0, 0, 0), (1, 2, 3), PAINT)) == pytest.approx(2 * 3 + 4 * 3 + 2)  # without its bottom
    assert area(rods([(0, 0, 0)], [(0, 0, 2)], 0.5, 0.5, PAINT, sides=90)) == pytest.approx(2 * np.pi, rel=1e-3)
    assert area(ellipsoid((0, 0, 0), 1.0, PAINT, 90)) == pytest.approx(4 * np.pi, rel=5e-3)
    assert area(prism([(0, 0), (1, 0), (0, 1)], 0.0, 1.0, PAINT)) == pytest.approx(1 + 2 + np.sqrt(2))


def test_boxes_stand_on_their_centres():
    mesh = boxes([(5, 6, 1)], (1, 2, 3), PAINT)
    np.testing.assert_allclose(mesh.corners.reshape(-1, 3).min(0), (4.5, 5, 1))
    np.testing.assert_allclose(mesh.corners.reshape(-1, 3).max(0), (5.5, 7, 4))


@given(heading=st.floats(-10, 10), x=st.floats(-50, 50), y=st.floats(-50, 50))
def test_placing_turns_counter_clockwise_then_moves(heading, x, y):
    placed = quads(SQUARE, PAINT).placed(x, y, heading)
    first_edge = placed.corners[0, 1] - placed.corners[0, 0]
    np.testing.assert_allclose(first_edge, (2 * np.cos(heading), 2 * np.sin(heading), 0), atol=1e-4)
    np.testing.assert_allclose(placed.corners[0, 0], (x, y, 0), atol=1e-4)


def test_joining_then_keeping_gives_back_the_parts():
    first, second = quads(SQUARE, PAINT), leaves(np.zeros((7, 3)), 0.2, PAINT, np.random.default_rng(0))
    both = Mesh.joined([first, second])
    again = both.kept(np.arange(len(both)) >= len(first))
    for name in ("corners", "uv", "colour", "layer", "matter", "rank"):
        np.testing.assert_array_equal(getattr(again, name), getattr(second, name))


def test_the_two_triangles_of_a_leaf_fall_together():
    rank = leaves(np.zeros((50, 3)), 0.2, PAINT, np.random.default_rng(0)).rank
    np.testing.assert_array_equal(rank[::2], rank[1::2])
    assert 0 <= rank.min() < rank.max() < 1


def test_normals_have_unit_length_and_none_for_a_point():
    np.testing.assert_allclose(np.abs(quads(SQUARE, PAINT).normals()), [(0, 0, 1)] * 2)
    assert not Mesh.of(np.zeros((1, 3, 3)), np.zeros((1, 3, 2)), PAINT).normals().any()
