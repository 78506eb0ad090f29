"""``andante history`` and ``andante rollback``: the versions of a map, and the way back to one of them."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any

import typer

from andante.cli.options import AsJson, MapFile
from andante.cli.output import examples, hint, print_json, print_table
from andante.cli.trials import held_out_mean

HISTORY_EPILOG = examples("andante history garden.andante", "andante history garden.andante --json")
_NO_DRIVES: dict[str, list[str]] = {"recordings": [], "new": []}
ROLLBACK_EPILOG = examples("andante rollback garden.andante", "andante rollback garden.andante --to 3")


def history(map_file: MapFile, as_json: AsJson = False) -> None:
    """Show the versions of a map that updates left behind, and the map as it is now."""
    from andante.mapping.history import digest_of, versions_of

    current, rows = digest_of(map_file), list[dict[str, Any]]()
    for version in versions_of(map_file):
        rows.append({"version": version.number, **_told(version.path, version.digest == current, rows)})
    if not any(row["current"] for row in rows):
        rows.append({"version": None, **_told(map_file, True, rows)})
    if as_json:
        print_json({"map": str(map_file), "versions": rows})
        return
    columns = ("version", "written", "drives", "new", "frames", "held-out mean", "MB", "")
    print_table(f"{map_file}", columns, [_row(row) for row in rows])
    now = next(at for at, row in reversed(list(enumerate(rows))) if row["current"])
    if now > 0:
        hint(f"back to the version before: andante rollback {map_file}")
    elif len(rows) > 1:
        hint(f"forward again: andante rollback {map_file} --to {rows[-1]['version']}")


def rollback(
    map_file: MapFile,
    to: Annotated[
        int | None, typer.Option(min=1, help="The number of the version. Default: the one before the current.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Put an earlier version of a map back, byte by byte; the current one is kept as a version too."""
    from andante.mapping.history import roll_back

    version = roll_back(map_file, to)
    if as_json:
        print_json({"map": str(map_file), "version": version.number, "bytes": version.bytes, "digest": version.digest})
    else:
        typer.echo(f"{map_file} is version {version.number} again; versions: andante history {map_file}")


def _told(path: Path, current: bool, earlier: list[dict[str, Any]]) -> dict[str, Any]:
    from andante.errors import MapError
    from andante.mapping import SlowMap

    status = path.stat()
    told: dict[str, Any] = {
        "written": datetime.fromtimestamp(status.st_mtime, UTC).isoformat(timespec="seconds"),
        "bytes": status.st_size,
        "current": current,
        "damaged": None,
    }
    try:
        described = SlowMap.load(path).describe()
    except MapError as error:  # the others are all the more needed
        return {**told, "damaged": str(error), **dict.fromkeys(("frames", "held_out_mean", "unit")), **_NO_DRIVES}
    names = [one["name"] for one in described["recordings"]]
    known = earlier[-1]["recordings"] if earlier else []
    return {
        **told,
        "recordings": names,
        "new": [name for name in names if name not in known],
        "frames": sum(one["frames"] for one in described["recordings"]),
        "held_out_mean": held_out_mean(described["cross_validation"]),
        "unit": described["unit"],
    }


def _row(row: dict[str, Any]) -> tuple[object, ...]:
    mean = row["held_out_mean"]
    return (
        "now" if row["version"] is None else row["version"],
        row["written"],
        len(row["recordings"]),
        ", ".join(row["new"]) or None,
        row["frames"],
        None if mean is None else f"{mean:.3f} {row['unit']}",
        round(row["bytes"] / 1e6, 2),
        "damaged" if row["damaged"] else "current" if row["current"] else None,
    )
