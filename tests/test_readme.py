"""What the documents tell people to type exists."""

import contextlib
import re
import shlex
from pathlib import Path

import pytest
import typer
from typer.main import get_command

from andante.cli import app

ROOT = Path(__file__).parents[1]
DOCUMENTS = (
    "README.md",
    "CONTRIBUTING.md",
    "docs/comparison.md",
    "docs/experiments.md",
    "docs/onnx.md",
    "docs/teaching.md",
    "docs/tracking.md",
)
COMMANDS = get_command(app).commands
_ENDS_A_COMMAND = {"|", ">", ">>", "&&", "||", ";", "&"}


def code_lines(document: str) -> list[str]:
    """Lines of the fenced shell blocks, prompts removed, continued lines joined."""
    text = (ROOT / document).read_text(encoding="utf-8")
    blocks = re.findall(r"^```(?:sh|bash|console|shell)?\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    lines = "\n".join(blocks).replace("\\\n", " ").splitlines()
    return [line.strip().removeprefix("$ ") for line in lines]


def lines_of(program: str) -> list[tuple[str, str]]:
    return [(name, line) for name in DOCUMENTS for line in code_lines(name) if line.split()[:1] == [program]]


def arguments_of(line: str) -> list[str]:
    words = shlex.split(line, comments=True)
    end = next((at for at, word in enumerate(words) if word in _ENDS_A_COMMAND), len(words))
    return words[1:end]


@pytest.mark.parametrize(("document", "line"), lines_of("andante"))
def test_commands_parse(document, line):
    name, *arguments = arguments_of(line)
    if name.startswith("-"):
        assert name in ("--help", "--version")
        return
    with contextlib.suppress(typer.Exit):  # --help
        COMMANDS[name].make_context(name, arguments)


@pytest.mark.parametrize(("document", "line"), lines_of("make"))
def test_make_targets_exist(document, line):
    targets = re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    assert {word for word in arguments_of(line) if "=" not in word} <= set(targets)


@pytest.mark.parametrize("name", COMMANDS)
def test_readme_names_every_command(name):
    assert f"andante {name}" in (ROOT / "README.md").read_text(encoding="utf-8")
