import os
import struct
import zlib
from contextlib import suppress

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.errors import ImageError
from andante.recordings import decode_image, read_image


def smooth(height=40, width=60):
    y, x = np.mgrid[:height, :width]
    return np.dstack([x * 4, y * 5, (x + y) * 2]).astype(np.uint8)


def encoded(extension, image=None):
    return cv2.imencode(extension, smooth() if image is None else image)[1].tobytes()


def png_that_declares(width, height):
    chunks = b""
    for kind, body in ((b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)), (b"IEND", b"")):
        chunks += struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    return b"\x89PNG\r\n\x1a\n" + chunks


@pytest.mark.parametrize("extension", [".jpg", ".png", ".bmp", ".webp"])
def test_reads_grey_and_colour(tmp_path, extension):
    path = tmp_path / f"now{extension}"
    path.write_bytes(encoded(extension))
    grey, colour = read_image(path), read_image(str(path), colour=True)
    assert grey.shape == (40, 60)
    assert colour.shape == (40, 60, 3)
    assert grey.dtype == colour.dtype == np.uint8
    assert np.abs(colour.astype(int) - smooth()).mean() < 4
    assert np.abs(grey.astype(int) - cv2.cvtColor(smooth(), cv2.COLOR_BGR2GRAY)).mean() < 4


def test_grey_file_read_in_colour_has_three_equal_channels():
    colour = decode_image(encoded(".png", smooth()[:, :, 0]), colour=True)
    assert colour.shape == (40, 60, 3)
    assert (colour == smooth()[:, :, :1]).all()


@pytest.mark.parametrize("colour", [False, True])
def test_sixteen_bits_are_reduced_to_the_upper_eight(colour):
    deep = smooth().astype(np.uint16) * 256 + 3
    expected = decode_image(encoded(".png", smooth()), colour=colour)
    assert np.abs(decode_image(encoded(".png", deep), colour=colour).astype(int) - expected).max() <= 1


@pytest.mark.parametrize("colour", [False, True])
def test_transparency_is_dropped(colour):
    transparent = np.dstack([smooth(), np.zeros((40, 60), np.uint8)])
    expected = decode_image(encoded(".png", smooth()), colour=colour)
    np.testing.assert_array_equal(decode_image(encoded(".png", transparent), colour=colour), expected)


def test_exif_orientation_is_ignored():
    tiff = b"II*\0\x08\0\0\0" + struct.pack("<HHHIHHI", 1, 0x112, 3, 1, 6, 0, 0)  # orientation 6: a quarter turn
    body = b"Exif\0\0" + tiff
    plain = encoded(".jpg")
    turned = plain[:2] + b"\xff\xe1" + struct.pack(">H", 2 + len(body)) + body + plain[2:]
    assert cv2.imdecode(np.frombuffer(turned, np.uint8), cv2.IMREAD_GRAYSCALE).shape == (60, 40)  # the trap is real
    np.testing.assert_array_equal(decode_image(turned), decode_image(plain))


def test_faults_of_the_path(tmp_path):
    with pytest.raises(ImageError, match=r"image .*nowhere\.jpg does not exist; check the path"):
        read_image(tmp_path / "nowhere.jpg")
    with pytest.raises(ImageError, match="is not a regular file"):
        read_image(tmp_path)
    os.mkfifo(tmp_path / "pipe.jpg")
    with pytest.raises(ImageError, match="is not a regular file"):
        read_image(tmp_path / "pipe.jpg")
    with pytest.raises(ImageError, match="cannot be read: File name too long"):
        read_image(tmp_path / ("x" * 300))


def test_a_file_larger_than_any_image_is_not_read(tmp_path):
    path = tmp_path / "huge.png"
    with path.open("wb") as file:
        file.truncate(600_000_000)  # sparse
    with pytest.raises(ImageError, match="600000000 bytes, at most 512000000 are read"):
        read_image(path)


def test_faults_of_the_content(tmp_path):
    with pytest.raises(ImageError, match="image: empty file; record or copy it again"):
        decode_image(b"")
    with pytest.raises(ImageError, match=r"not a JPEG, PNG, BMP or WebP image \(it starts with 68 65 6c 6c\)"):
        decode_image(b"hello world")
    with pytest.raises(ImageError, match="a RIFF file of another kind"):
        decode_image(b"RIFF" + bytes(4) + b"WAVEfmt " + bytes(30))
    with pytest.raises(ImageError, match=r"now: declares 100000 x 100000 pixels, at most 64 megapixels"):
        decode_image(png_that_declares(100_000, 100_000), name="now")
    with pytest.raises(ImageError, match="cannot be decoded"):
        decode_image(png_that_declares(10, 10))  # no pixels at all
    with pytest.raises(ImageError, match="cannot be decoded"):
        decode_image(png_that_declares(2_000_000, 2))  # wider than cv2 allows, it raises its own error
    with pytest.raises(ImageError, match="cannot be decoded"):
        decode_image(png_that_declares(0, 10))


@pytest.mark.parametrize("extension", [".jpg", ".png", ".bmp", ".webp"])
@pytest.mark.parametrize("share", [0.5, 0.9, 0.999])
def test_truncated_files_are_never_half_a_picture(extension, share, capfd):
    whole = encoded(extension, smooth(200, 300))
    with pytest.raises(ImageError, match=r"truncated or damaged \(\d+ bytes of 300 x 200 pixels\); record or copy"):
        decode_image(whole[: int(len(whole) * share)])
    assert capfd.readouterr().err == ""


@given(st.binary(max_size=200))
def test_any_bytes_give_an_image_or_an_image_error(data):
    with suppress(ImageError):
        assert decode_image(data).ndim == 2


@given(extension=st.sampled_from([".jpg", ".png", ".bmp", ".webp"]), data=st.data())
def test_any_flipped_byte_gives_an_image_or_an_image_error(extension, data):
    damaged = bytearray(encoded(extension))
    at = data.draw(st.integers(0, len(damaged) - 1))
    damaged[at] ^= data.draw(st.integers(1, 255))
    with suppress(ImageError):
        assert decode_image(bytes(damaged), colour=True).ndim == 3
