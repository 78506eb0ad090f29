"""The commands under one name, and the one place where expected errors become a line and an exit code."""

from __future__ import annotations

import sys
from typing import Annotated, Any, NoReturn

import typer
from typer.core import TyperGroup

from andante.cli import (
    compare,
    demo,
    doctor,
    evaluate,
    experiment,
    export,
    history,
    info,
    learn_landmarks,
    localize,
    merge,
    navigate,
    simulate,
    teach,
    track,
    update,
)
from andante.cli import map as map_
from andante.cli.output import complain, examples
from andante.errors import AndanteError

EXPECTED_ERROR = 1
INTERRUPTED = 130


class ErrorBoundary(TyperGroup):
    """Ends expected errors with one line on stderr; anything else is a bug and keeps its traceback."""

    def invoke(self, ctx: Any) -> Any:  # noqa: ANN401 (the parent's, whose type typer keeps private)
        """Run the command; raises ``typer.Exit`` with 1 for expected errors and 130 for an interrupt."""
        try:
            result = super().invoke(ctx)
            sys.stdout.flush()  # a reader that went away is noticed here, not when the interpreter ends
        except AndanteError as error:
            _end(str(error), EXPECTED_ERROR)
        except BrokenPipeError:
            raise  # typer ends quietly
        except OSError as error:  # a full disk, a lost permission: the machine's answer, no bug
            _end(f"{error.filename or 'a file'}: {error.strerror}; check path, permissions and space", EXPECTED_ERROR)
        except KeyboardInterrupt:
            _end("interrupted", INTERRUPTED)
        return result


def _end(message: str, code: int) -> NoReturn:
    complain(message)
    raise typer.Exit(code)


app = typer.Typer(
    name="andante",
    cls=ErrorBoundary,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog=examples(
        "andante map garden/monday garden/friday -o garden.andante",
        "andante localize garden.andante now.jpg",
        "andante evaluate garden.andante garden/sunday --report report",
        "andante track garden.andante garden/sunday --report report",
        "andante update garden.andante garden/winter",
    ),
)

app.command("map", epilog=map_.EPILOG)(map_.command)
app.command("localize", epilog=localize.EPILOG)(localize.command)
app.command("evaluate", epilog=evaluate.EPILOG)(evaluate.command)
app.command("compare", epilog=compare.EPILOG)(compare.command)
app.command("track", epilog=track.EPILOG)(track.command)
app.command("update", epilog=update.EPILOG)(update.command)
app.command("merge", epilog=merge.EPILOG)(merge.command)
app.command("history", epilog=history.HISTORY_EPILOG)(history.history)
app.command("rollback", epilog=history.ROLLBACK_EPILOG)(history.rollback)
app.command("simulate", epilog=simulate.EPILOG)(simulate.command)
app.command("navigate", epilog=navigate.EPILOG)(navigate.command)
app.command("teach", epilog=teach.EPILOG)(teach.command)
app.command("learn-landmarks", epilog=learn_landmarks.EPILOG)(learn_landmarks.command)
app.command("export", epilog=export.EPILOG)(export.command)
app.command("info", epilog=info.EPILOG)(info.command)
app.command("doctor", epilog=doctor.EPILOG)(doctor.command)
app.command("demo", epilog=demo.EPILOG)(demo.command)
app.command("experiment", epilog=experiment.EPILOG)(experiment.command)


def _print_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f"andante {version('andante')}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Map a place from a few drives with one panoramic camera, then tell from one image where a robot is.

    Every command prints tables for people, or one JSON object with --json; messages go to stderr. Exit status: 0 done,
    1 an error that the message explains, 2 wrong usage.
    """


def main() -> None:
    """The entry point of the command ``andante``."""
    app(prog_name="andante")
