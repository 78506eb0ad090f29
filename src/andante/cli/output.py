"""How commands speak: results to stdout, everything else to stderr."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from rich.console import Console

_ROWS_AT_EACH_END = 10
_FILE_COLUMNS = 160  # where no terminal sets the width


def examples(*lines: str) -> str:
    """The epilog of a help text; blank lines keep the lines apart."""
    return "\n\n".join(["[bold]Examples[/bold]", *(f"  {line}" for line in lines)])


def complain(message: str) -> None:
    """One line on stderr that begins with "error:"."""
    typer.echo(f"error: {' '.join(message.split())}", err=True)


def hint(message: str) -> None:
    """One line on stderr that begins with "hint:"."""
    typer.echo(f"hint: {message}", err=True)


def print_json(values: Mapping[str, Any]) -> None:
    """One JSON object on stdout; what is not finite becomes null."""
    typer.echo(json.dumps(_finite(values), allow_nan=False))


def print_facts(title: str, facts: Mapping[str, object]) -> None:
    """Names and values below each other."""
    print_table(title, ("", ""), [(name, _cell(value)) for name, value in facts.items()], show_header=False)


def print_table(
    title: str, columns: Sequence[str], rows: Sequence[Sequence[object]], *, show_header: bool = True
) -> None:
    """A table on stdout: numbers to the right, both ends of a long one, no columns without any value."""
    from rich import box
    from rich.table import Table

    used = [at for at in range(len(columns)) if any(row[at] is not None for row in rows)]
    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, show_header=show_header)
    for at in used:
        numeric = all(row[at] is None or isinstance(row[at], int | float) for row in rows)
        table.add_column(columns[at], overflow="fold", justify="right" if numeric else "left")
    left_out = len(rows) - 2 * _ROWS_AT_EACH_END
    for number, row in enumerate(rows):
        if left_out <= 1 or not 0 <= number - _ROWS_AT_EACH_END < left_out:
            table.add_row(*(_cell(row[at]) for at in used))
        elif number == _ROWS_AT_EACH_END:
            table.add_row(f"... {left_out} more", *["..."] * (len(used) - 1))
    _console().print(table)


@contextmanager
def progress_bars() -> Iterator[Callable[[str, int, int], None]]:
    """A callback (stage, done, total) that draws one bar per stage on stderr, where that is a terminal."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    console = _console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    tasks: dict[str, Any] = {}
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bars:

        def show(stage: str, done: int, total: int) -> None:
            if stage not in tasks:
                tasks[stage] = bars.add_task(stage)
            bars.update(tasks[stage], completed=done, total=total)

        yield show


def _console(*, stderr: bool = False) -> Console:
    from rich.console import Console

    # Names of files and recordings are text, not markup.
    console = Console(stderr=stderr, markup=False, highlight=False)
    if not console.is_terminal:
        console.width = _FILE_COLUMNS
    return console


def _cell(value: object) -> str:
    if value is None:
        return "-"
    return f"{value:.3f}" if isinstance(value, float) else str(value)


def _finite(value: object) -> object:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(key): _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return value
