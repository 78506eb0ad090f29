"""The sections of a report that tell of a simulated garden: how it looks, where the map was right, what is slow."""

from __future__ import annotations

from collections.abc import Sequence

from andante.data import FloatArray, ImageArray, Pose2D
from andante.evaluation import garden_plots
from andante.evaluation.comparison import Evaluation
from andante.evaluation.plots import svg
from andante.evaluation.report import mapped_places
from andante.evaluation.sections import Picture, Section
from andante.evaluation.spatial import SpatialMaps, axis_correlations
from andante.evaluation.top_view import top_view
from andante.mapping import SlowMap
from andante.simulator import Plan, SimulatedCamera, SimulatedRecording

_PANORAMA = SimulatedCamera(model="panorama", width_px=960, height_px=160, min_deg=-15.0, max_deg=45.0)
_AROUND_M = 5.0


def sections_of(
    plan: Plan, sessions: Sequence[str], evaluation: Evaluation, slowmap: SlowMap, maps: SpatialMaps
) -> list[Section]:
    """The whole story: ``sessions`` of the plan, the last of which was localized; slow features over its places."""
    return [
        _one_place(plan, sessions),
        _from_above(plan, sessions[-1], evaluation, mapped_places(slowmap)),
        _slow_features(plan, maps),
    ]


def view_of(plan: Plan, session: str, pose: Pose2D) -> ImageArray:
    """What the robot would see all around it, BGR (160, 960, 3), its forward in the middle."""
    panoramic = plan.model_copy(update={"camera": _PANORAMA})
    return SimulatedRecording(panoramic, session).renderer.render(pose).image


def _one_place(plan: Plan, sessions: Sequence[str]) -> Section:
    pose = SimulatedRecording(plan, sessions[0]).infos[0].reference or Pose2D(0.0, 0.0)
    pictures = tuple(Picture.of_image(session, view_of(plan, session, pose)) for session in sessions)
    text = f"What the robot sees around it at x = {pose.x_m:.1f} m, y = {pose.y_m:.1f} m, unrolled."
    return Section("One place in every session", text, pictures)


def _from_above(plan: Plan, session: str, evaluation: Evaluation, mapped_m: FloatArray) -> Section:
    """The garden from above with mapped places (r, 2), the way, and the estimates coloured by their error."""
    scene = plan.scene(session)  # in summer dress, in which lawn and path can be told apart
    view = top_view(scene, plan.garden.size_x_m + _AROUND_M, plan.garden.size_y_m + _AROUND_M)
    plot = garden_plots.localized_garden(evaluation, mapped_m, view, scene.obstacles)
    caption = f"{session}: every image localized by itself, without odometry (background in summer dress)"
    return Section("The garden from above", "", (Picture.of_svg(caption, plot),))


def _slow_features(plan: Plan, maps: SpatialMaps) -> Section:
    xy, values = maps.places
    first, second, _ = axis_correlations(xy, values[:, 0], values[:, 1])
    text = (
        "Learnt with a small version of the thesis' network from pictures all over the garden, those of neighbouring "
        "places joined by their known positions, and shown for the same pictures, blue to red (its figure 9.1 a). The "
        f"first two correlate with two orthogonal axes by {first:.2f} and {second:.2f}; the others are higher modes."
    )
    plot = svg(garden_plots.feature_maps(maps, plan.scene(plan.sessions[0].name).obstacles))
    return Section("What is slow", text, (Picture.of_svg("the slowest features, slowest first", plot),))
