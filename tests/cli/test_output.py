import json

import numpy as np

from andante.cli.output import complain, print_facts, print_json, print_table


def test_json_has_no_nan(capsys):
    print_json({"a": float("nan"), "b": [1.5, float("inf")], "c": {"d": (float("-inf"), None, "x", 3)}})
    assert json.loads(capsys.readouterr().out) == {"a": None, "b": [1.5, None], "c": {"d": [None, None, "x", 3]}}


def test_json_takes_numpy_floats(capsys):
    print_json({"a": np.float64("nan"), "b": np.float64(0.5)})
    assert json.loads(capsys.readouterr().out) == {"a": None, "b": 0.5}


def test_complaints_are_one_line(capsys):
    complain("first\n  second")
    assert capsys.readouterr().err == "error: first second\n"


def test_tables_leave_out_empty_columns_and_mark_gaps(capsys):
    print_table("title", ("name", "x [m]", "heading"), [("a", 1.23456, None), ("b", None, None)])
    out = capsys.readouterr().out
    assert "heading" not in out
    assert "1.235" in out
    assert "-" in out.splitlines()[-2]


def test_names_are_no_markup(capsys):
    print_facts("[bold]title", {"[red]": "[/red]"})
    out = capsys.readouterr().out
    assert all(text in out for text in ("[bold]title", "[red]", "[/red]"))
