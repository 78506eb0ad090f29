import pytest

KEYS = {
    "n", "median_m", "mean_m", "p95_m", "max_m", "share_over_1m", "share_over_3m", "heading_median_deg", "lost_share",
    "ms_per_image",
}  # fmt: skip


def test_json_tells_all(garden, andante):
    answer = andante("evaluate", garden.map, garden.sunday, "--baselines", "--json")
    assert answer.exit_code == 0, answer.stderr
    values = answer.json
    assert set(values) >= KEYS | {"baselines", "report"}
    assert values["n"] == 40
    assert values["median_m"] < 0.3
    assert values["report"] is None
    assert values["baselines"]
    assert all(set(one) >= KEYS for one in values["baselines"].values())


def test_table(garden, andante):
    answer = andante("evaluate", garden.map, garden.sunday, "--baselines", "--train", garden.monday)
    assert answer.exit_code == 0, answer.stderr
    assert "sunday: 40 images" in answer.stdout
    assert "median [m]" in answer.stdout
    assert any(line.split()[:1] == ["map"] for line in answer.stdout.splitlines())


def test_report(garden, andante, tmp_path):
    answer = andante("evaluate", garden.map, garden.sunday, "--report", tmp_path / "new", "--json")
    assert answer.exit_code == 0, answer.stderr
    page = tmp_path / "new" / "report.html"
    assert answer.json["report"] == str(page)
    assert page.is_file()


def test_training_data_is_refused_unless_asked_for(garden, andante, fails):
    fails(andante("evaluate", garden.map, garden.monday), "learnt from recording 'monday'")
    answer = andante("evaluate", garden.map, garden.monday, "--training-error")
    assert answer.exit_code == 0
    assert "hint: training error" in answer.stderr


@pytest.mark.parametrize("as_json", [(), ("--json",)])
def test_expected_errors(garden, andante, tmp_path, fails, as_json):
    fails(andante("evaluate", garden.map, garden.no_poses, *as_json), "'no_poses' has no reference poses")
    fails(andante("evaluate", tmp_path / "no.andante", garden.sunday, *as_json), "no.andante cannot be read")
    fails(andante("evaluate", garden.map, garden.sunday, "--report", garden.map, *as_json), "--report .* is a file")
