import pytest


@pytest.fixture
def data(tmp_path, garden):
    """Small drives under the names of the example garden."""
    (tmp_path / "garden_a").mkdir()
    for season, drive in (("summer", garden.monday), ("autumn", garden.tuesday), ("winter", garden.sunday)):
        (tmp_path / "garden_a" / f"border_{season}").symlink_to(drive)
    return tmp_path


def test_whole_story(andante, data, tmp_path):
    folder = tmp_path / "output" / "demo"
    answer = andante("demo", folder, "--data", data)
    assert answer.exit_code == 0, answer.stderr
    assert f"report: {folder / 'report.html'}" in answer.stdout.replace("\n", " ")
    assert "sunday: 40 images" in answer.stdout
    assert "features" in answer.stdout
    assert (folder / "report.html").is_file()
    assert (folder / "garden.andante").is_file()


def test_json(andante, data, tmp_path, monkeypatch):
    monkeypatch.setenv("ANDANTE_DATA", str(data))
    values = andante("demo", tmp_path / "demo", "--json").json
    assert values["n"] == 40
    assert set(values) >= {"median_m", "baselines", "seconds", "report"}


def test_data_is_missing(andante, tmp_path, fails):
    fails(andante("demo", tmp_path / "demo", "--data", tmp_path), "needs .*border_summer, which is missing.*--data")
    assert not (tmp_path / "demo").exists()
