import onnx
import pytest


def test_json(garden, andante, tmp_path):
    target = tmp_path / "garden.onnx"
    answer = andante("export", garden.map, "-o", target, "--json")
    assert answer.exit_code == 0, answer.stderr
    assert set(answer.json) == {"map", "onnx", "bytes", "opset", "inputs", "outputs"}
    assert (answer.json["map"], answer.json["onnx"]) == (str(garden.map), str(target))
    assert answer.json["bytes"] == target.stat().st_size
    assert answer.json["inputs"] == {"image": [120, 120]}
    assert answer.json["outputs"]["slow"] == [20]
    onnx.checker.check_model(str(target))


def test_table_and_size(garden, andante, tmp_path):
    answer = andante("export", garden.map, "-o", tmp_path / "m.onnx", "--image-size", "240x240")
    assert answer.exit_code == 0, answer.stderr
    for words in ("240", "opset", "covariance", "MB"):
        assert words in answer.stdout


@pytest.mark.parametrize("size", ["240", "240x", "0x240", "axb", "99999x9", "240x240x3"])
def test_no_size(size, garden, andante, fails, tmp_path):
    answer = andante("export", garden.map, "-o", tmp_path / "m.onnx", "--image-size", size)
    fails(answer, f"--image-size '{size}' is no size: give width and height in pixels")


def test_faults(garden, andante, fails, tmp_path):
    fails(andante("export", garden.map, "-o", tmp_path / "no" / "m.onnx"), "-o .*m.onnx: the folder .* does not exist")
    fails(andante("export", tmp_path / "no.andante", "-o", tmp_path / "m.onnx"), "map .*no.andante cannot be read")
    answer = andante("export", garden.map, "-o", tmp_path / "m.onnx", "--image-size", "200x100")
    fails(answer, "200x100 px does not fit the camera")
