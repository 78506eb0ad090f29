"""Estimates as files that other programs read, written whole or not at all."""

from __future__ import annotations

import csv
import io
import math
from pathlib import Path

from andante.errors import InputError
from andante.evaluation.running import Run
from andante.files import replace_file

_TUM_HEADER = (
    "# timestamp x y z qx qy qz qw\n"
    "# seconds, metres; frames without a pose are left out; an unknown heading is the identity quaternion\n"
)
_COLUMNS = ("timestamp_s", "image", "x_m", "y_m", "heading_rad", "radius_m", "status", "reason", "place")


def write_tum(path: str | Path, run: Run) -> None:
    """Write the frames with a pose in the format of the TUM RGB-D benchmark, as evo and others read it.

    Raises ``InputError`` for a run on numbered places, which has no metres, and where the file cannot be written.
    """
    if any(frame.estimate.place is not None for frame in run.frames):
        raise InputError("places have no position in metres for a TUM file; write a CSV file instead")
    lines = [_TUM_HEADER]
    for frame in run.frames:
        estimate = frame.estimate
        if estimate.x_m is None or estimate.y_m is None:
            continue
        half = (estimate.heading_rad or 0.0) / 2
        pose = f"{estimate.x_m:.6f} {estimate.y_m:.6f} 0 0 0 {math.sin(half):.9f} {math.cos(half):.9f}"
        lines.append(f"{frame.info.timestamp_s!r} {pose}\n")
    write_text(path, "".join(lines))


def write_csv(path: str | Path, run: Run) -> None:
    """Write all frames that could be read, with blank cells where a value is unknown.

    Raises ``InputError`` where the file cannot be written.
    """
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(_COLUMNS)
    for frame in run.frames:
        values = {"timestamp_s": frame.info.timestamp_s, "image": frame.info.image, **frame.estimate.as_dict()}
        rows.writerow([values[column] for column in _COLUMNS])
    write_text(path, text.getvalue())


def write_text(path: str | Path, text: str) -> None:
    """Write UTF-8 as ``write_bytes`` does."""
    write_bytes(path, text.encode("utf-8"))


def write_bytes(path: str | Path, data: bytes) -> None:
    """Write whole or not at all; raises ``InputError``."""
    try:
        replace_file(Path(path), data)
    except OSError as error:
        raise InputError(f"{path} cannot be written: {error.strerror}; choose another place") from None
