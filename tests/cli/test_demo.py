import sys
import webbrowser

import pytest

SMALL = ("--frames", 20, "--image-px", 64)


@pytest.fixture(scope="module")
def told(andante, tmp_path_factory):
    pytest.importorskip("embreex", reason="rays need the extra sim: pip install 'andante[sim]'")
    folder = tmp_path_factory.mktemp("demo") / "output"
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("os.cpu_count", lambda: 1)
        return folder, andante("demo", folder, *SMALL)


def test_whole_story(told):
    folder, answer = told
    assert answer.exit_code == 0, answer.stderr
    assert f"report: {folder / 'report.html'}" in answer.stdout.replace("\n", " ")
    assert "winter: 20 images" in answer.stdout
    for stage in ("render", "map", "localize", "slow features", "report", "total"):
        assert stage in answer.stdout
    assert (folder / "garden.andante").is_file()
    page = (folder / "report.html").read_text(encoding="utf-8")
    for heading in ("One place in every session", "The garden from above", "What is slow", "Seconds", "Figures"):
        assert f"<h2>{heading}</h2>" in page


def test_json_and_what_is_rendered_is_used_again(told, andante, monkeypatch):
    folder, _ = told
    opened = []
    monkeypatch.setattr("andante.evaluation.story.sections_of", lambda *_: [])
    monkeypatch.setattr(webbrowser, "open", opened.append)
    tables = {path: path.stat().st_mtime_ns for path in folder.glob("*/*/frames.csv")}
    assert len(tables) == 4
    values = andante("demo", folder, *SMALL, "--open", "--json").json
    assert values["n"] == 20
    assert set(values) >= {"median_m", "baselines", "seconds", "report"}
    assert {path: path.stat().st_mtime_ns for path in folder.glob("*/*/frames.csv")} == tables
    assert opened == [(folder / "report.html").resolve().as_uri()]


def test_a_file_is_no_place_for_it(andante, tmp_path, fails):
    (tmp_path / "file").write_text("")
    fails(andante("demo", tmp_path / "file"), "DIR .*file is a file")


def test_without_embreex_it_says_what_to_install(andante, tmp_path, fails, monkeypatch):
    for name in {"embreex", *(name for name in sys.modules if name.startswith("embreex."))}:
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    fails(andante("demo", tmp_path / "x", *SMALL), r"embreex is not installed; install it .*'andante\[sim\]'")
