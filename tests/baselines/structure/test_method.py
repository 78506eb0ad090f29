import sys

import numpy as np
import pytest

from andante.baselines.method import Method
from andante.baselines.structure import Sift, Structure
from andante.baselines.structure.keyframes import Keyframes
from andante.baselines.structure.reconstruction import reconstructions
from andante.data import CameraSpec, FloatArray, Pose2D, Status
from andante.errors import ConfigError, LearningError, MissingExtraError, RecordingError
from andante.recordings import MemoryRecording
from andante.simulator import GardenSpec, Plan, Session, SimulatedCamera, SimulatedRecording

pytestmark = pytest.mark.usefixtures("colmap")

SPEC = CameraSpec(centre_px=(31.5, 31.5), radius_px=32.0)


@pytest.fixture(scope="module")
def garden_drive() -> MemoryRecording:
    """Rendered pictures of the beginning of a border, with their truth."""
    pytest.importorskip("embreex", reason="rays need the extra sim: pip install 'andante[sim]'")
    session = Session(name="monday", seed=1, drive={"kind": "border", "laps": 0.12})
    camera = SimulatedCamera(width_px=120, height_px=120)
    plan = Plan(garden=GardenSpec(seed=3, size_x_m=10, size_y_m=10), camera=camera, sessions=(session,))
    rendered = SimulatedRecording(plan, "monday")
    infos = rendered.infos
    return MemoryRecording(
        [rendered.load(info) for info in infos],
        [info.timestamp_s for info in infos],
        rendered.camera,
        reference=[info.reference for info in infos],
        name="monday",
    )


def featureless(n: int = 12, heading: float | None = 0.0) -> MemoryRecording:
    poses = [Pose2D(0.3 * i, 0.0, heading) for i in range(n)]
    images = [np.full((64, 64), 80, np.uint8)] * n
    return MemoryRecording(images, np.arange(float(n)), SPEC, reference=poses, name="fog")


def test_a_rendered_drive_is_localized_also_between_its_mapped_pictures(garden_drive) -> None:
    told = []
    method = Structure(poses="given", every_m=0.2, sift=Sift(contrast=0.004))
    learned = method.learn([garden_drive], progress=lambda *step: told.append(step[0]))
    estimates = [
        (learned.localizer.localize(garden_drive.load(info)), info.reference) for info in garden_drive.infos[::2]
    ]
    errors = [np.hypot(e.x_m - pose.x_m, e.y_m - pose.y_m) for e, pose in estimates if e.status is Status.OK]
    assert isinstance(method, Method)
    assert set(told) == {"key points", "matching", "structure"}
    assert "frames registered in 1 models" in learned.notes[0]
    assert len(errors) >= 8
    assert np.median(errors) < 0.1
    assert learned.bytes == learned.localizer.cloud.nbytes > 1000
    assert min(learned.preprocessing_s, learned.mapping_s) > 0


@pytest.mark.parametrize(("poses", "tolerance_m"), [("given", 0.05), ("estimated", 0.1)])
def test_points_lie_where_they_are_in_the_frame_of_the_positions(world, loop, poses, tolerance_m) -> None:
    rng = np.random.default_rng(0)
    seen = [world.keypoints(pose, rng) for pose in loop]
    keyframes = Keyframes(seen, loop[:, :2], loop[:, 2], np.zeros(len(loop), np.int64))
    cloud, notes = Structure(poses=poses).reconstruct(world.view, keyframes)
    likeness = cloud.descriptors.astype(float) @ world.descriptors.astype(float).T
    off_m: FloatArray = np.linalg.norm(cloud.xyz - world.xyz[likeness.argmax(axis=1)], axis=1)
    assert notes == (f"16 of 16 frames registered in 1 models, {len(cloud)} points",)
    assert len(cloud) > 100
    assert np.median(off_m) < tolerance_m


@pytest.mark.parametrize("known", [True, False])
def test_known_poses_serve_where_too_few_are_found(world, loop, known, monkeypatch: pytest.MonkeyPatch) -> None:
    def none_found(*given, poses=None, **options):
        return [] if poses is None else reconstructions(*given, poses=poses, **options)

    monkeypatch.setattr("andante.baselines.structure.method.reconstructions", none_found)
    rng = np.random.default_rng(0)
    seen = [world.keypoints(pose, rng) for pose in loop]
    heading = loop[:, 2] if known else np.full(len(loop), np.nan)
    keyframes = Keyframes(seen, loop[:, :2], heading, np.zeros(len(loop), np.int64))
    if not known:
        with pytest.raises(LearningError, match=r"nothing could be reconstructed from 16 frames"):
            Structure().reconstruct(world.view, keyframes)
        return
    cloud, notes = Structure().reconstruct(world.view, keyframes)
    assert len(cloud) > 100
    assert notes[0].startswith("0 of 16 frames registered")
    assert notes[1].startswith("too few, after 0 s")
    assert notes[1].endswith("from the given poses instead")
    assert notes[2:] == (f"16 of 16 frames registered in 1 models, {len(cloud)} points",)


def test_a_reconstruction_that_does_not_fit_the_positions_is_no_map(world, loop) -> None:
    rng = np.random.default_rng(0)
    seen = [world.keypoints(pose, rng) for pose in loop[:14]]
    keyframes = Keyframes(seen, rng.uniform(-90, 90, (14, 2)), np.full(14, np.nan), np.zeros(14, np.int64))
    with pytest.raises(LearningError, match=r"a part of \d+ frames was left out: the reconstruction does not fit"):
        Structure(tolerance_m=1e-3, radius_m=200.0).reconstruct(world.view, keyframes)


def test_the_variants_have_names() -> None:
    assert [Structure(view=view).name for view in ("fisheye", "pinhole")] == ["structure-fisheye", "structure-pinhole"]


@pytest.mark.parametrize("poses", ["given", "estimated"])
def test_pictures_that_show_nothing_cannot_be_learnt_from(poses) -> None:
    with pytest.raises(LearningError, match=r"nothing could be reconstructed from 12 frames with 0 key points each"):
        Structure(poses=poses).learn([featureless()])


def test_given_poses_need_headings() -> None:
    with pytest.raises(RecordingError, match=r"12 of 12 frames have no heading, .* use poses='estimated'"):
        Structure(poses="given").learn([featureless(heading=None)])


def test_something_has_to_be_given() -> None:
    with pytest.raises(RecordingError, match=r"no recording was given"):
        Structure().learn([])


def test_other_cameras_are_refused() -> None:
    panorama = MemoryRecording([np.zeros((8, 32), np.uint8)], [0.0], CameraSpec(model="panorama"))
    with pytest.raises(ConfigError, match=r"only a camera of model 'fisheye' has a fisheye lens"):
        Structure().learn([panorama])


def test_without_colmap_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pycolmap", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'andante\[structure\]'"):
        Structure().learn([featureless()])
