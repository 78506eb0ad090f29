"""The table of frames: text with a header line to checked ``FrameInfo``, line by line."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath, PureWindowsPath

from andante.data import FrameInfo, Pose2D
from andante.errors import RecordingError

REQUIRED_COLUMNS = ("timestamp_s", "image")
ODOMETRY_COLUMNS = ("odom_x_m", "odom_y_m", "odom_heading_rad")
REFERENCE_COLUMNS = ("x_m", "y_m", "heading_rad")
COLUMNS = (*REQUIRED_COLUMNS, *ODOMETRY_COLUMNS, *REFERENCE_COLUMNS, "place")

# float() and int() would also take "nan", "1_000" and digits of other scripts
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_LARGEST = 1e9  # of metres or radians: its square and its sums are far from overflow
_WHOLE_NUMBER = re.compile(r"[+-]?\d{1,18}", re.ASCII)


@dataclass(frozen=True, slots=True)
class Table:
    """A table as text: the header, and the cells of every row with the number of its line; ``source`` names it."""

    source: str
    header: tuple[str, ...]
    rows: tuple[tuple[int, tuple[str, ...]], ...]


def read_text(path: Path) -> str:
    """The text of a UTF-8 file without its byte order mark; raises ``RecordingError``."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:  # csv wants line ends as they are
            return file.read()
    except FileNotFoundError:
        raise RecordingError(f"{path} does not exist; check the path") from None
    except OSError as error:
        raise RecordingError(f"{path} cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise RecordingError(f"{path} is not UTF-8 text (byte {error.start}); save it as UTF-8") from None


def parse_table(text: str, source: str, *, delimiter: str = ",") -> Table:
    """Split text into a header and rows as RFC 4180 does; blank lines are dropped. Raises ``RecordingError``."""
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, strict=True)
    header: tuple[str, ...] = ()
    rows: list[tuple[int, tuple[str, ...]]] = []
    try:
        for cells in reader:
            row = tuple(cell.strip() for cell in cells)
            if not any(row):
                continue
            if not header:
                header = row
            elif len(row) != len(header):
                raise RecordingError(
                    f"{source} line {reader.line_num}: {len(row)} cells, the header has {len(header)}; "
                    f"leave a cell blank where a value is unknown"
                )
            else:
                rows.append((reader.line_num, row))
    except csv.Error as error:
        raise RecordingError(f"{source} line {reader.line_num}: not a table ({error}); check its quotes") from None
    doubles = sorted({name for name in header if header.count(name) > 1})
    if doubles:
        raise RecordingError(f"{source}: column {doubles[0]!r} appears twice in the header; keep one")
    if not rows:
        raise RecordingError(f"{source}: no rows; a recording needs a header line and at least one frame")
    return Table(source, header, tuple(rows))


def own_columns(table: Table) -> dict[str, str]:
    """The mapping for a table in our own names; a column that is none of ``COLUMNS`` raises ``RecordingError``."""
    unknown = [name for name in table.header if name not in COLUMNS]
    if unknown:
        raise RecordingError(f"{table.source}: unknown column {unknown[0]!r}; allowed are {', '.join(COLUMNS)}")
    return {name: name for name in table.header}


def frame_infos(table: Table, columns: Mapping[str, str], *, ticks_per_second: float = 1.0) -> tuple[FrameInfo, ...]:
    """The frames of a table whose headers ``columns`` names (ours -> theirs), times in ticks.

    Blank cells are unknown values, except for time and image. Raises ``RecordingError`` with line and column
    for a value that is no finite number, a pose beyond 1e9, half a position, an image outside of the folder, times that
    do not increase.
    """
    for name in REQUIRED_COLUMNS:
        if columns.get(name) not in table.header:
            raise RecordingError(
                f"{table.source}: no column {columns.get(name, name)!r} for {name}; found {', '.join(table.header)}"
            )
    places = {ours: table.header.index(theirs) for ours, theirs in columns.items()}
    infos: list[FrameInfo] = []
    for index, (line, cells) in enumerate(table.rows):
        row = _Row(table.source, line, {ours: cells[at] for ours, at in places.items()}, columns)
        infos.append(
            FrameInfo(
                index=index,
                image=row.image(),
                timestamp_s=row.timestamp() / ticks_per_second,
                odometry=row.pose(ODOMETRY_COLUMNS),
                reference=row.pose(REFERENCE_COLUMNS),
                place=row.place(),
            )
        )
    lines = [f"line {line}" for line, _ in table.rows]
    check_times([info.timestamp_s for info in infos], lines, table.source)
    return tuple(infos)


def check_times(timestamps_s: Sequence[float], labels: Sequence[str], source: str) -> None:
    """Raise ``RecordingError`` with two of the ``labels`` unless all times are finite and strictly increase."""
    for label, time in zip(labels, timestamps_s, strict=True):
        if not math.isfinite(time):
            raise RecordingError(f"{source} {label}: time {time!r} is not finite; every frame needs a time in seconds")
    for at in range(1, len(timestamps_s)):
        before, after = timestamps_s[at - 1], timestamps_s[at]
        if after <= before:
            raise RecordingError(
                f"{source}: times must increase, {labels[at]} has {after!r} s after {before!r} s in {labels[at - 1]}; "
                f"sort the frames and drop doubles"
            )


@dataclass(frozen=True, slots=True)
class _Row:
    """One line of a table, its cells by our names."""

    source: str
    line: int
    cells: Mapping[str, str]
    columns: Mapping[str, str]

    def timestamp(self) -> float:
        time = self._number("timestamp_s")
        if time is None:
            raise self._fault("timestamp_s", "is blank; every frame needs a time")
        return time

    def image(self) -> str:
        name = self.cells["image"]
        if not name:
            raise self._fault("image", "is blank; every frame needs an image")
        if re.search(r"[\x00-\x1f\x7f]", name):
            raise self._fault("image", "holds control characters; give a file name")
        if PurePosixPath(name).is_absolute() or PureWindowsPath(name).anchor or ".." in re.split(r"[/\\]", name):
            raise self._fault("image", "leads out of the recording; paths are relative to its folder, without '..'")
        return name

    def pose(self, names: tuple[str, str, str]) -> Pose2D | None:
        x, y, heading = (self._number(name) for name in names)
        for name, value in zip(names, (x, y, heading), strict=True):
            if value is not None and abs(value) > _LARGEST:
                raise self._fault(name, f"is beyond {_LARGEST:g}; give metres and radians")
        if x is not None and y is not None:
            return Pose2D(x, y, heading)
        if x is None and y is None and heading is None:
            return None
        missing = names[0] if x is None else names[1]
        raise self._fault(missing, "is blank beside other values of this pose; give x and y, or leave all blank")

    def place(self) -> int | None:
        cell = self.cells.get("place", "")
        if cell and not _WHOLE_NUMBER.fullmatch(cell):
            raise self._fault("place", "is not a whole number of at most 18 digits; give one or leave it blank")
        return int(cell) if cell else None

    def _number(self, name: str) -> float | None:
        cell = self.cells.get(name, "")
        if not cell:
            return None
        value = float(cell) if _NUMBER.fullmatch(cell) else math.nan
        if not math.isfinite(value):
            raise self._fault(name, "is not a finite number; give one or leave the cell blank where it is unknown")
        return value

    def _fault(self, name: str, what: str) -> RecordingError:
        cell = self.cells.get(name, "")
        value = f" {cell[:80]!r}" if cell else ""
        return RecordingError(f"{self.source} line {self.line}, column {self.columns.get(name, name)}:{value} {what}")
