"""``andante doctor``: is this machine ready."""

from __future__ import annotations

import typer

from andante.cli.options import AsJson
from andante.cli.output import complain, examples, hint, print_json, print_table

EPILOG = examples("andante doctor", "andante doctor --json")


def command(as_json: AsJson = False) -> None:
    """Check whether this machine is ready: versions, processors, image decoding, memory, disk."""
    from andante.cli.checks import run_checks

    checks = run_checks()
    faults = [check for check in checks if not check.ok]
    if as_json:
        print_json({"ready": not faults, "checks": [check.as_dict() for check in checks]})
    else:
        rows = [(check.name, "ok" if check.ok else "FAULT", check.found) for check in checks]
        print_table("This machine", ("check", "", "found"), rows)
    for check in faults:
        hint(f"{check.name}: {check.advice}")
    if faults:
        complain(f"this machine is not ready: {', '.join(check.name for check in faults)}")
        raise typer.Exit(1)
    if not as_json:
        typer.echo("ready")
