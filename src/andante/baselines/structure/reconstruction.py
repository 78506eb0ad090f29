"""Structure from motion with COLMAP (Schonberger and Frahm 2016) in a folder that is gone afterwards."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np

from andante.baselines.structure.keypoints import Keypoints
from andante.baselines.structure.library import SEED, colmap
from andante.baselines.structure.views import View
from andante.data import FloatArray, IndexArray
from andante.mapping import Progress
from andante.recordings import default_workers

if TYPE_CHECKING:
    import pycolmap

_FEWEST_IMAGES = 10
_BLOCK = 250
"""Pairs matched between two signs of progress."""


def reconstructions(
    keypoints: Sequence[Keypoints],
    camera: pycolmap.Camera,
    pairs: IndexArray,
    *,
    poses: Sequence[FloatArray] | None = None,
    progress: Progress | None = None,
) -> list[pycolmap.Reconstruction]:
    """``pycolmap.Reconstruction`` objects, the largest first, whose images have numbers from 1 in the given order.

    ``pairs`` (m, 2) are those to be matched. With ``poses``, (3, 4) from world to camera, only the points are
    triangulated, otherwise the poses are found as well, in any number of parts that do not hang together. ``camera``
    stays as it is. Raises ``MissingExtraError`` without COLMAP.
    """
    step = progress or _silent
    with TemporaryDirectory(prefix="andante-structure-") as name:
        folder = Path(name)
        database = folder / "database.db"
        _write_database(database, keypoints, camera)
        _match(folder, database, pairs, step)
        if poses is not None:
            return [_triangulated(folder, database, poses, step)]
        return _mapped(folder, database, len(keypoints), step)


def camera_poses(view: View, xy: FloatArray, heading: FloatArray) -> list[FloatArray]:
    """Positions (n, 2) and headings (n,) of a robot on level ground -> n times (3, 4) from world to camera.

    The height of the camera is zero.
    """
    cos, sin, zero, one = np.cos(heading), np.sin(heading), np.zeros_like(heading), np.ones_like(heading)
    robot_from_world = np.stack([[cos, sin, zero], [-sin, cos, zero], [zero, zero, one]]).transpose(2, 0, 1)
    camera_from_world = view.robot_from_camera.T @ robot_from_world
    centres = np.column_stack([xy, zero])[:, :, None]
    return list(np.concatenate([camera_from_world, -camera_from_world @ centres], axis=2))


def _silent(_stage: str, _done: int, _total: int) -> None:
    """Progress that nobody asked for."""


def _write_database(path: Path, keypoints: Sequence[Keypoints], camera: pycolmap.Camera) -> None:
    library = colmap()
    with library.Database.open(path) as database:
        camera.camera_id = database.write_camera(camera)
        rig = library.Rig()
        rig.add_ref_sensor(camera.sensor_id)
        rig.rig_id = database.write_rig(rig)
        for number, one in enumerate(keypoints, start=1):
            image = library.Image(name=f"{number:06d}", camera_id=camera.camera_id, image_id=number)
            database.write_image(image, use_image_id=True)
            frame = library.Frame(frame_id=number, rig_id=rig.rig_id)
            frame.add_data_id(image.data_id)
            database.write_frame(frame, use_frame_id=True)
            database.write_keypoints(number, one.xy)
            descriptors = library.FeatureDescriptors(library.FeatureExtractorType.SIFT, one.descriptors)
            database.write_descriptors(number, descriptors)


def _match(folder: Path, database: Path, pairs: IndexArray, step: Progress) -> None:
    """Match and verify: what cannot be verified by a relative pose does not count."""
    library = colmap()
    matching = library.FeatureMatchingOptions(num_threads=default_workers(), use_gpu=False)
    verification = library.TwoViewGeometryOptions()
    verification.ransac.random_seed = SEED
    listed = folder / "pairs.txt"
    pairing = library.ImportedPairingOptions(match_list_path=listed)
    step("matching", 0, len(pairs))
    for first in range(0, len(pairs), _BLOCK):
        block = pairs[first : first + _BLOCK].tolist()
        listed.write_text("".join(f"{a + 1:06d} {b + 1:06d}\n" for a, b in block), encoding="utf-8")
        library.match_image_pairs(database, matching, pairing, verification, library.Device.cpu)
        step("matching", first + len(block), len(pairs))


def _options() -> pycolmap.IncrementalPipelineOptions:
    """The intrinsics are known. Several threads sum in another order, so the last digits may differ between runs."""
    library = colmap()
    options: pycolmap.IncrementalPipelineOptions = library.IncrementalPipelineOptions(
        num_threads=default_workers(),
        random_seed=SEED,
        extract_colors=False,
        ba_refine_focal_length=False,
        ba_refine_principal_point=False,
        ba_refine_extra_params=False,
        min_model_size=_FEWEST_IMAGES,
    )
    options.mapper.abs_pose_refine_focal_length = False
    options.mapper.abs_pose_refine_extra_params = False
    return options


def _mapped(folder: Path, database: Path, images: int, step: Progress) -> list[pycolmap.Reconstruction]:
    registered = 0

    def count() -> None:
        nonlocal registered
        registered = min(registered + 1, images)
        step("structure", registered, images)

    models = colmap().incremental_mapping(database, folder, folder, _options(), next_image_callback=count)
    return sorted(models.values(), key=lambda model: -model.num_reg_images())


def _triangulated(folder: Path, database: Path, poses: Sequence[FloatArray], step: Progress) -> pycolmap.Reconstruction:
    library = colmap()
    model: pycolmap.Reconstruction = library.Reconstruction()
    with library.Database.open(database) as stored:
        cameras, rigs, frames, images = (
            stored.read_all_cameras(),
            stored.read_all_rigs(),
            stored.read_all_frames(),
            stored.read_all_images(),
        )
    for camera in cameras:
        model.add_camera(camera)
    for rig in rigs:
        model.add_rig(rig)
    for frame in frames:
        frame.rig_from_world = library.Rigid3d(np.asarray(poses[frame.frame_id - 1]))
        model.add_frame(frame)
    for image in images:
        model.add_image(image)
    for frame in frames:
        model.register_frame(frame.frame_id)
    step("structure", 0, len(poses))
    model = library.triangulate_points(model, database, folder, folder, options=_options())
    step("structure", len(poses), len(poses))
    return model
