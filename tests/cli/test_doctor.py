from types import SimpleNamespace

from andante.cli import checks


def test_this_machine(andante):
    answer = andante("doctor", "--json")
    values = answer.json
    names = [check["name"] for check in values["checks"]]
    assert names == [
        "python", "packages", "one cv2 wheel", "processors", "image decoding", "free memory", "temporary folder",
    ]  # fmt: skip
    assert values["ready"] is all(check["ok"] for check in values["checks"])
    assert answer.exit_code == (0 if values["ready"] else 1)


def test_ready(andante, monkeypatch):
    monkeypatch.setattr(checks, "run_checks", lambda: [checks.Check("python", True, "3.11")])
    answer = andante("doctor")
    assert (answer.exit_code, answer.stderr) == (0, "")
    assert answer.stdout.rstrip().endswith("ready")


def test_a_fault_says_what_to_do(andante, monkeypatch):
    faulty = checks.Check("free memory", False, "0.1 GB", "close other programs")
    monkeypatch.setattr(checks, "run_checks", lambda: [faulty])
    answer = andante("doctor")
    assert answer.exit_code == 1
    assert answer.stderr.splitlines() == [
        "hint: free memory: close other programs",
        "error: this machine is not ready: free memory",
    ]
    assert "ready" not in answer.stdout
    answer = andante("doctor", "--json")
    assert answer.exit_code == 1
    assert answer.json["ready"] is False


def test_two_cv2_wheels_are_a_fault(monkeypatch):
    names = ("opencv-python-headless", "numpy", "OpenCV_contrib_python")
    found = [SimpleNamespace(metadata={"Name": name}) for name in names]
    monkeypatch.setattr(checks, "distributions", lambda: found)
    monkeypatch.setattr(checks, "_decoding", lambda: checks.Check("image decoding", True, ""))
    check = next(check for check in checks.run_checks() if check.name == "one cv2 wheel")
    assert not check.ok
    assert check.advice == (
        "run: pip uninstall -y opencv-contrib-python opencv-python-headless && pip install opencv-python-headless"
    )


def test_a_missing_package_is_a_fault(monkeypatch):
    monkeypatch.setattr(checks, "_PACKAGES", ("numpy", "no-such-package"))
    check = next(check for check in checks.run_checks() if check.name == "packages")
    assert not check.ok
    assert check.advice == "run: pip install no-such-package"
