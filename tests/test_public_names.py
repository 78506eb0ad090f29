import ast
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import andante


def imports_for_type_checkers() -> dict[str, str]:
    """Name -> module of the block that only type checkers see."""
    tree = ast.parse(Path(inspect.getfile(andante)).read_text(encoding="utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If))
    return {
        alias.asname or alias.name: node.module or ""
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }


@pytest.mark.parametrize("name", andante.__all__)
def test_every_name_can_be_had(name):
    value = getattr(andante, name)
    assert getattr(andante, name) is value
    assert name in dir(andante)


def test_type_checkers_see_the_same_names():
    seen = imports_for_type_checkers()
    assert {*seen, "__version__"} == set(andante.__all__)
    assert seen == {name: f"andante.{room}" for name, room in andante._ROOM_OF.items()}


def test_names_are_sorted():
    assert list(andante.__all__) == sorted(andante.__all__, key=lambda name: (not name[0].isupper(), name))


def test_unknown_name():
    with pytest.raises(AttributeError, match="no attribute 'slowness'"):
        _ = andante.slowness


def test_import_is_light():
    code = "import sys, andante; print(' '.join(sys.modules))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert not {"numpy", "scipy", "cv2", "pydantic", "typer", "rich"} & {name.split(".")[0] for name in loaded}
    assert [name for name in loaded if name.startswith("andante")] == ["andante"]
