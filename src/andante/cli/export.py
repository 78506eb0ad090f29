"""``andante export``: a map in, an ONNX file out."""

from __future__ import annotations

import re
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer

from andante.cli.options import AsJson, MapFile, check_place
from andante.cli.output import examples, hint, print_facts, print_json
from andante.errors import InputError

EPILOG = examples(
    "andante export garden.andante -o garden.onnx",
    "andante export garden.andante -o small.onnx --image-size 240x240 --json",
)
_LARGEST_SIDE_PX = 2**13


def command(
    map_file: MapFile,
    *,
    output: Annotated[
        Path,
        typer.Option(
            "--output", "-o", metavar="ONNX", show_default=False, help="The ONNX file to write; replaced on success."
        ),
    ],
    image_size: Annotated[
        str | None,
        typer.Option(
            metavar="WxH", help="Size of the images in pixels, as 480x480. Default: that of the map's camera."
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Write a map as an ONNX file, which localizes without Python (extra onnx)."""
    from andante.export import export_onnx
    from andante.mapping import SlowMap

    check_place(output, "-o")
    shape = None if image_size is None else _image_shape(image_size)
    slowmap = SlowMap.load(map_file)
    exported = export_onnx(slowmap, output, image_shape=shape)
    if slowmap.landmarks is not None:
        hint("the landmarks of this map are left out: the graph goes by the whole image alone")
    summary = {"map": str(map_file), "onnx": str(output), **asdict(exported)}
    if as_json:
        print_json(summary)
    else:
        _print(summary)


def _image_shape(size: str) -> tuple[int, int]:
    """(height, width) from WxH."""
    sides = re.fullmatch(r"([0-9]{1,5})x([0-9]{1,5})", size)
    width, height = map(int, sides.groups()) if sides else (0, 0)
    if not (1 <= width <= _LARGEST_SIDE_PX and 1 <= height <= _LARGEST_SIDE_PX):
        raise InputError(
            f"--image-size {size!r:.40} is no size: give width and height in pixels from 1 to {_LARGEST_SIDE_PX} with "
            "an x between them, as 480x480"
        )
    return height, width


def _print(summary: dict[str, Any]) -> None:
    shapes = {
        side: ", ".join(f"{name} {tuple(shape)}" for name, shape in summary[side].items())
        for side in ("inputs", "outputs")
    }
    print_facts(summary["onnx"], {"size": f"{summary['bytes'] / 1e6:.2f} MB", "opset": summary["opset"], **shapes})
