"""The pictures of docs/simulator.md, rendered anew; a minute.

python benchmarks/pictures.py [-o docs/images]
"""

import argparse
from pathlib import Path

import cv2
import numpy as np

from andante.data import ImageArray, Pose2D
from andante.simulator import (
    BorderRun,
    Conditions,
    GardenSpec,
    Plan,
    Rendering,
    Session,
    SimulatedCamera,
    SimulatedRecording,
    object_boxes,
)  # fmt: skip

GARDEN = GardenSpec(seed=3)
WIDE = SimulatedCamera(model="panorama", width_px=1000, height_px=180, min_deg=-17.0, max_deg=46.0)
FISHEYE = SimulatedCamera(width_px=520, height_px=520)
LIGHTS = {
    "morning": {"hour": 7.5, "sun_energy": 4.5},
    "noon": {"hour": 12.0, "sun_energy": 6.5},
    "evening": {"hour": 16.5, "sun_energy": 5.0, "sun_red": 1.0},
    "sun from the other side": {"sun_y_m": -9.0, "sun_energy": 6.0},
    "strong sun, clear sky": {"sun_energy": 8.0, "clouds": 0.1},
    "little red": {"sun_red": 0.5},
    "overcast": {"overcast": True, "sun_energy": 4.0},
}
OBJECTS = ("car", "bicycle", "chair", "umbrella", "suitcase", "cow", "person")


def look(camera: SimulatedCamera, conditions: Conditions, pose: Pose2D, objects: tuple[str, ...] = ()) -> Rendering:
    session = Session(name="drive", seed=5, drive=BorderRun(), conditions=conditions, objects=objects)
    recording = SimulatedRecording(Plan(garden=GARDEN, camera=camera, sessions=(session,)), "drive")
    return recording.renderer.render(pose)


def pose_on_the_way(share: float) -> Pose2D:
    session = Session(name="drive", seed=5, drive=BorderRun())
    infos = SimulatedRecording(Plan(garden=GARDEN, sessions=(session,)), "drive").infos
    return infos[int(share * len(infos))].reference


def captioned(image: ImageArray, text: str) -> ImageArray:
    strip = np.full((24, image.shape[1], 3), 255, np.uint8)
    cv2.putText(strip, text, (4, 17), cv2.FONT_HERSHEY_SIMPLEX, 0.5, (60, 60, 60), 1, cv2.LINE_AA)
    return np.concatenate([strip, image])


def seasons(pose: Pose2D) -> ImageArray:
    names = ("spring", "summer", "autumn", "winter")
    return np.concatenate([captioned(look(WIDE, Conditions(season=name), pose).image, name) for name in names])


def lights(pose: Pose2D) -> ImageArray:
    small = WIDE.model_copy(update={"width_px": 800, "height_px": 144})
    return np.concatenate(
        [captioned(look(small, Conditions(**values), pose).image, name) for name, values in LIGHTS.items()]
    )


def truth(pose: Pose2D) -> ImageArray:
    """Colour with boxes, object ids and range of the same panorama."""
    found = look(WIDE, Conditions(), pose, OBJECTS)
    scene = SimulatedRecording(
        Plan(garden=GARDEN, camera=WIDE, sessions=(Session(name="drive", seed=5, objects=OBJECTS),)), "drive"
    ).plan.scene("drive")
    boxed = found.image.copy()
    for box in object_boxes(found.object_id, scene.names, wraps=True, min_pixels=60):
        if box.name.rstrip("0123456789") not in OBJECTS:
            continue
        cv2.rectangle(boxed, (box.x_min, box.y_min), (box.x_max, box.y_max), (40, 40, 230), 1)
        cv2.putText(
            boxed, box.name, (box.x_min, max(box.y_min - 3, 9)), cv2.FONT_HERSHEY_SIMPLEX, 0.38, (40, 40, 230), 1,
            cv2.LINE_AA,
        )  # fmt: skip
    palette = np.random.default_rng(1).integers(40, 230, (int(found.object_id.max()) + 2, 3), dtype=np.uint8)
    palette[-1] = 255
    ids = palette[found.object_id]
    near = np.clip(1.0 - np.log10(np.maximum(found.range_m, 0.5) / 0.5) / 2.0, 0.0, 1.0)
    ranges = cv2.applyColorMap((255 * np.nan_to_num(near)).astype(np.uint8), cv2.COLORMAP_VIRIDIS)
    parts = {
        "picture, boxes of what moves": boxed,
        "object ids": ids,
        "range, the brighter the nearer, dark beyond 50 m": ranges,
    }
    return np.concatenate([captioned(image, name) for name, image in parts.items()])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", type=Path, default=Path("docs/images"))
    folder = parser.parse_args().o
    folder.mkdir(parents=True, exist_ok=True)
    pose = pose_on_the_way(0.3)
    pictures = {
        "seasons": seasons(pose),
        "lights": lights(pose),
        "fisheye": look(FISHEYE, Conditions(), pose).image,
        "truth": truth(pose_on_the_way(0.62)),
    }
    for name, image in pictures.items():
        path = folder / f"simulator_{name}.jpg"
        cv2.imwrite(str(path), image, [cv2.IMWRITE_JPEG_QUALITY, 82])
        print(f"{path}: {path.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main()
