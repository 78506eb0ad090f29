import os
import subprocess
import sys
from importlib.metadata import version

import pytest
from typer.main import get_command

from andante.cli import app

MAIN = (sys.executable, "-c", "from andante.cli import main; main()")
COMMANDS = get_command(app).commands
OPTIONS = [(name, parameter) for name, command in COMMANDS.items() for parameter in command.params]


def test_commands():
    assert list(COMMANDS) == [
        "map",
        "localize",
        "evaluate",
        "compare",
        "track",
        "update",
        "merge",
        "history",
        "rollback",
        "simulate",
        "navigate",
        "teach",
        "learn-landmarks",
        "export",
        "info",
        "doctor",
        "demo",
        "experiment",
    ]


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_teaches(name, andante):
    command = COMMANDS[name]
    assert command.help
    assert f"andante {name}" in command.epilog
    answer = andante(name, "--help")
    assert answer.exit_code == 0
    assert "Examples" in answer.stdout


@pytest.mark.parametrize(("name", "parameter"), OPTIONS, ids=[f"{name} {one.name}" for name, one in OPTIONS])
def test_every_parameter_says_what_it_is_for(name, parameter):
    assert parameter.help
    if not parameter.required:
        assert "Default: " in parameter.help


def test_root(andante):
    answer = andante("--help")
    assert answer.exit_code == 0
    assert all(name in answer.stdout for name in COMMANDS)
    assert andante("--version").stdout == f"andante {version('andante')}\n"
    assert andante().exit_code == 2
    assert andante("fly").exit_code == 2


def test_interrupt(garden, andante, monkeypatch):
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("andante.recordings.open_recording", interrupted)
    answer = andante("info", garden.monday)
    assert (answer.exit_code, answer.stdout, answer.stderr) == (130, "", "error: interrupted\n")


def test_a_full_disk_is_no_bug(garden, andante, monkeypatch, fails):
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device", "m.andante")

    monkeypatch.setattr("andante.recordings.open_recording", full)
    fails(andante("info", garden.monday), "m.andante: No space left on device; check")


def test_bugs_keep_their_traceback(garden, andante, monkeypatch):
    monkeypatch.setattr("andante.recordings.open_recording", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        andante("info", garden.monday)


def test_a_reader_that_goes_away_is_no_error(garden):
    read, write = os.pipe()
    os.close(read)
    try:
        done = subprocess.run(
            [*MAIN, "info", garden.monday, "--json"], stdout=write, stderr=subprocess.PIPE, check=False
        )
    finally:
        os.close(write)
    assert done.stderr == b""
    assert done.returncode == 1


def test_entry_point(garden):
    done = subprocess.run([*MAIN, "info", garden.map / "no"], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith("error: map ")


def test_commands_import_nothing_heavy():
    code = "import sys, andante.cli; print(' '.join(sys.modules))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    heavy = {"numpy", "scipy", "cv2", "matplotlib", "pydantic", "safetensors", "jinja2", "PIL", "onnx"}
    assert not heavy & {name.split(".")[0] for name in loaded}
