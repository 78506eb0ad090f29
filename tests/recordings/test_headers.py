import struct
from contextlib import suppress

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.errors import ImageError
from andante.recordings.headers import read_header

EXTENSIONS = [".jpg", ".png", ".bmp", ".webp"]


def encoded(extension, height=30, width=50, channels=3, settings=()):
    rng = np.random.default_rng(1)
    image = rng.integers(0, 256, (height, width, channels), dtype=np.uint8)
    return cv2.imencode(extension, image, list(settings))[1].tobytes()


@pytest.mark.parametrize("extension", EXTENSIONS)
@given(height=st.integers(1, 70), width=st.integers(1, 70), channels=st.sampled_from([1, 3]))
def test_declared_size_is_the_size(extension, height, width, channels):
    header = read_header(encoded(extension, height, width, channels))
    assert (header.height, header.width, header.complete) == (height, width, True)


@pytest.mark.parametrize(
    ("extension", "channels", "settings"),
    [
        (".jpg", 3, (cv2.IMWRITE_JPEG_PROGRESSIVE, 1)),
        (".jpg", 3, (cv2.IMWRITE_JPEG_RST_INTERVAL, 1)),
        (".webp", 4, (cv2.IMWRITE_WEBP_QUALITY, 50)),  # lossy with alpha: the extended format
        (".webp", 3, (cv2.IMWRITE_WEBP_QUALITY, 50)),
        (".webp", 3, (cv2.IMWRITE_WEBP_QUALITY, 101)),  # lossless
        (".png", 4, ()),
        (".bmp", 4, ()),
    ],
)
def test_variants_of_formats(extension, channels, settings):
    header = read_header(encoded(extension, 33, 47, channels, settings))
    assert (header.height, header.width, header.complete) == (33, 47, True)


@pytest.mark.parametrize("extension", EXTENSIONS)
@given(data=st.data())
def test_no_shortened_file_is_complete(extension, data):
    whole = encoded(extension)
    cut = data.draw(st.integers(1, len(whole) - 1))
    with suppress(ImageError):  # cut inside the header
        assert not read_header(whole[:cut]).complete


def test_end_marker_of_a_thumbnail_does_not_count():
    whole = encoded(".jpg")
    thumbnail = b"\xff\xe1" + struct.pack(">H", 2 + 6) + b"ab\xff\xd9cd"
    with_thumbnail = whole[:2] + thumbnail + whole[2:]
    assert read_header(with_thumbnail).complete
    assert not read_header(with_thumbnail[:-2]).complete


def test_bytes_behind_the_end_of_a_jpeg_are_harmless():
    assert read_header(encoded(".jpg") + b"\0" * 100).complete


def test_a_jpeg_that_ends_before_its_scan():
    whole = encoded(".jpg")
    assert not read_header(whole[:20] + b"\xff\xd9").complete


def test_bitmaps_with_the_oldest_header_and_rows_from_the_top():
    oldest = b"BM" + struct.pack("<IIIIHHHH", 0, 0, 26, 12, 3, 2, 1, 24) + bytes(24)
    assert (read_header(oldest).width, read_header(oldest).height, read_header(oldest).complete) == (3, 2, True)
    assert not read_header(oldest[:-1]).complete
    downwards = bytearray(encoded(".bmp", 30, 50))
    downwards[22:26] = struct.pack("<i", -30)
    assert (read_header(bytes(downwards)).height, read_header(bytes(downwards)).complete) == (30, True)


def test_one_flipped_bit_in_a_png_is_seen():
    data = bytearray(encoded(".png"))
    data[len(data) // 2] ^= 1
    assert not read_header(bytes(data)).complete


@given(st.sampled_from([b"", b"\xff\xd8\xff", b"\x89PNG\r\n\x1a\n", b"BM", b"RIFF"]), st.binary(max_size=80))
def test_any_bytes_give_a_header_or_an_image_error(signature, rest):
    with suppress(ImageError):
        header = read_header(signature + rest)
        assert min(header.width, header.height) >= 0
