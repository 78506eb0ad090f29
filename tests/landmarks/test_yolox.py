"""YOLOX: rows of a table become boxes, other files are refused with a reason."""

import builtins

import numpy as np
import pytest
from onnx import TensorProto
from yolox_files import row_of, table, write_yolox

from andante.errors import ImageError, InputError, MissingExtraError
from andante.landmarks.coco_names import COCO_NAMES
from andante.landmarks.yolox import AnchorDetector

BLUE = np.zeros((64, 64, 3), np.uint8)
BLUE[..., 0] = 255
SUITCASE = COCO_NAMES.index("suitcase")


def test_there_are_80_classes_in_the_order_of_coco():
    assert len(set(COCO_NAMES)) == 80
    assert [COCO_NAMES.index(name) for name in ("person", "bicycle", "car", "umbrella", "toothbrush")] == [
        0,
        1,
        2,
        25,
        79,
    ]


def test_a_row_is_decoded_on_the_grid_of_its_stride(tmp_path):
    rows = {row_of(16, 2, 1): ((0.5, 0.25, np.log(1.5), np.log(0.5)), SUITCASE, 0.8)}
    (found,) = AnchorDetector(write_yolox(tmp_path / "a.onnx", table(rows)))(BLUE)
    # Middle (2.5, 1.25) cells of 16 px, 24 x 8 px large.
    assert found.pixels == pytest.approx((28.0, 16.0, 52.0, 24.0), abs=1e-4)
    assert (found.name, found.score) == ("suitcase", pytest.approx(0.8))


def test_pictures_are_bgr_and_shrunk_into_the_upper_left_of_grey(tmp_path):
    rows = {row_of(32, 0, 0): ((0.5, 0.25, 0.0, np.log(0.5)), 2, 1.0)}
    detector = AnchorDetector(write_yolox(tmp_path / "a.onnx", table(rows)))
    (found,) = detector(np.full((128, 256, 3), (255, 0, 0), np.uint8))
    assert found.score == pytest.approx(1.0)
    assert found.pixels == pytest.approx((0.0, 0.0, 128.0, 64.0), abs=1e-3)
    (red,) = detector(np.full((128, 256, 3), (0, 0, 255), np.uint8))
    assert red.score == pytest.approx(114 / 255)  # only the grey around it has any blue


def test_of_boxes_over_one_another_the_surest_of_each_class_counts(tmp_path):
    here = (0.5, 0.5, 0.0, 0.0)
    near = (0.4, 0.5, 0.0, 0.0)
    rows = {
        row_of(8, 3, 3): (here, 2, 0.6),
        row_of(16, 0, 3): (here, 2, 0.5),
        row_of(8, 3, 4): ((0.5, -0.4, 0.0, 0.0), 2, 0.9),
        row_of(8, 4, 3): ((-0.6, 0.5, 0.0, 0.0), 7, 0.7),
        row_of(8, 2, 0): (near, 2, 0.1),
    }
    found = AnchorDetector(write_yolox(tmp_path / "a.onnx", table(rows)))(BLUE)
    assert [(one.name, round(one.score, 3)) for one in found] == [("car", 0.9), ("truck", 0.7), ("car", 0.5)]


def test_nothing_sure_is_nothing(tmp_path):
    detector = AnchorDetector(write_yolox(tmp_path / "a.onnx", table({0: ((0, 0, 0, 0), 0, 0.2)})))
    assert detector(BLUE) == []
    assert len(detector(BLUE, 0.1)) == 1


@pytest.mark.parametrize("picture", [BLUE[..., 0], BLUE.astype(np.float32), BLUE[:0]])
def test_other_pictures_are_refused(tmp_path, picture):
    detector = AnchorDetector(write_yolox(tmp_path / "a.onnx", table({})))
    with pytest.raises(ImageError, match=r"BGR pictures \(height, width, 3\) uint8, got shape"):
        detector(picture)


def test_a_missing_file_is_an_error(tmp_path):
    with pytest.raises(InputError, match=r"none\.onnx is no file; give the path of a YOLOX file"):
        AnchorDetector(tmp_path / "none.onnx")


def test_a_file_that_is_no_onnx_is_an_error(tmp_path):
    path = tmp_path / "a.onnx"
    path.write_bytes(b"no model")
    with pytest.raises(InputError, match=r"cannot be read as ONNX .*; fetch it again"):
        AnchorDetector(path)


def test_other_classes_are_an_error(tmp_path):
    path = write_yolox(tmp_path / "a.onnx", table({}, columns=25))
    with pytest.raises(InputError, match=r"knows 20 classes, not the 80 of COCO; give one that learnt from COCO"):
        AnchorDetector(path)


def test_other_inputs_and_outputs_are_errors(tmp_path):
    grey = write_yolox(tmp_path / "grey.onnx", table({}), inputs=1)
    with pytest.raises(InputError, match=r"has inputs \[\(1, 1, 64, 64\)\].*a YOLOX file takes one picture"):
        AnchorDetector(grey)
    bytes_ = write_yolox(tmp_path / "bytes.onnx", table({}), kind=TensorProto.UINT8)
    with pytest.raises(InputError, match=r"takes or gives .*tensor\(uint8\), not floats; a YOLOX file takes"):
        AnchorDetector(bytes_)
    short = write_yolox(tmp_path / "short.onnx", table({})[:, :50])
    with pytest.raises(InputError, match=r"gives 50 rows for 64 px, expected 84"):
        AnchorDetector(short)


def test_without_onnxruntime_the_message_says_what_to_install(tmp_path, monkeypatch):
    real = builtins.__import__

    def blocked(name, *rest, **more):
        if name == "onnxruntime":
            raise ImportError(name)
        return real(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", blocked)
    with pytest.raises(MissingExtraError, match=r"pip install 'andante\[landmarks\]'"):
        AnchorDetector(tmp_path / "a.onnx")


def test_the_real_weights_are_a_detector(weights):
    detector = AnchorDetector(weights)
    assert detector.size_px == 416
    assert detector(np.full((100, 200, 3), 90, np.uint8)) == []
