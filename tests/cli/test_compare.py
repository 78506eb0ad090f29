import json

import pytest

KEYS = {"median_m", "mean_m", "q75_m", "max_m", "share_over_1m", "share_over_3m", "lost_share", "heading_median_deg"}
QUICK = ("--method", "andante", "--method", "nearest-5", "--method", "thumbnails")


@pytest.fixture(scope="module")
def compared(garden, andante, tmp_path_factory):
    report = tmp_path_factory.mktemp("compared") / "new"
    answer = andante("compare", garden.monday, garden.tuesday, "--test", garden.sunday, *QUICK, "--report", report)
    assert answer.exit_code == 0, answer.stderr
    return answer, report


def test_tables(compared):
    answer, report = compared
    assert "sunday: 40 images" in answer.stdout
    assert "median [m]" in answer.stdout
    rows = [line.split()[0] for line in answer.stdout.splitlines() if line.strip()]
    for name in QUICK[1::2]:
        assert rows.count(name) >= 2
    assert "measured on" in answer.stdout
    assert "andante" in answer.stdout
    assert (report / "report.html").is_file()


def test_json_is_one_object(garden, andante):
    answer = andante("compare", garden.monday, "--test", garden.sunday, *QUICK[:4], "--json")
    assert answer.exit_code == 0, answer.stderr
    values = answer.json
    assert list(values["methods"]) == ["andante", "nearest-5"]
    assert values["mapped"] == ["monday"]
    assert values["tests"] == ["sunday"]
    for one in values["methods"].values():
        assert one["failure"] is None
        assert one["learning_s"] == pytest.approx(one["preprocessing_s"] + one["mapping_s"])
        assert set(one["tests"]["sunday"]) >= KEYS
        assert one["tests"]["sunday"]["median_m"] < 0.3
    assert values["verdicts"]["sunday: 40 images"]
    assert values["report"] is None
    assert json.dumps(values)


def test_list(andante):
    answer = andante("compare", "--list")
    assert answer.exit_code == 0
    assert "gaussian-process" in answer.stdout
    listed = andante("compare", "--list", "--json").json["methods"]
    assert listed[0]["name"] == "andante"
    assert all(set(one) == {"name", "what", "missing"} for one in listed)


def test_wrong_usage(garden, andante):
    for arguments in ((), (garden.monday,), ("--test", garden.sunday)):
        answer = andante("compare", *arguments)
        assert (answer.exit_code, answer.stdout) == (2, "")
        assert "at least one drive with --test" in answer.stderr


@pytest.mark.parametrize("as_json", [(), ("--json",)])
def test_expected_errors(garden, andante, fails, as_json):
    options = (*QUICK[:2], *as_json)
    fails(andante("compare", garden.monday, "--test", garden.monday, *options), "test recording 'monday' is 'monday'")
    fails(andante("compare", garden.monday, "--test", garden.no_poses, *options), "'no_poses' has no reference poses")
    fails(andante("compare", garden.monday, "--test", garden.sunday, "--method", "orb"), "no method 'orb'; choose from")
    fails(
        andante("compare", garden.monday, "--test", garden.sunday, "--report", garden.map, *options),
        "--report .* is a file",
    )
