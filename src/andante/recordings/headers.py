"""What the bytes of an image file declare, read before any decoder sees them.

A decoder allocates what a header declares, so a file of a few kilobytes can ask for gigabytes; and some
versions of cv2 decode a truncated JPEG to a picture that is half grey, without a word. Both are found here.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable
from dataclasses import dataclass

from andante.errors import ImageError

_PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_JPEG_STANDALONE = frozenset({0x01, *range(0xD0, 0xD9)})  # TEM, RST0..7 and SOI carry no length
_JPEG_FRAME = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}  # SOF0..15 without DHT, JPG, DAC
_JPEG_SCAN, _JPEG_END = 0xDA, 0xD9


@dataclass(frozen=True, slots=True)
class ImageHeader:
    """The size in pixels that a file declares, and whether the file reaches its own end."""

    width: int
    height: int
    complete: bool


def read_header(data: bytes) -> ImageHeader:
    """The declared size of a JPEG, PNG, BMP or WebP file; raises ``ImageError`` for anything else."""
    for signature, parse in _PARSERS:
        if data.startswith(signature):
            try:
                return parse(data)
            except (struct.error, IndexError):  # the bytes end inside the header
                raise ImageError("truncated inside its header; record or copy it again") from None
    raise ImageError(f"not a JPEG, PNG, BMP or WebP image (it starts with {data[:4].hex(' ')})")


def _parse_png(data: bytes) -> ImageHeader:
    width, height = struct.unpack_from(">II", data, 16)
    return ImageHeader(width, height, _png_is_complete(data))


def _png_is_complete(data: bytes) -> bool:
    """Whether every chunk up to IEND is there and unharmed (PNG specification 5.3: length, type, data, CRC)."""
    view = memoryview(data)
    at = len(_PNG_SIGNATURE)
    while at + 12 <= len(data):
        length = int.from_bytes(view[at : at + 4])
        end = at + 12 + length
        if end > len(data) or zlib.crc32(view[at + 4 : end - 4]) != int.from_bytes(view[end - 4 : end]):
            return False
        if data[at + 4 : at + 8] == b"IEND":
            return True
        at = end
    return False


def _parse_jpeg(data: bytes) -> ImageHeader:
    """Walk the marker segments to the first scan (ITU-T T.81 annex B).

    Inside a scan FF is always followed by 00 or a restart marker, so FF D9 behind its start is the true end
    of the image and not that of a thumbnail in the metadata.
    """
    width = height = 0
    at = 2
    while True:
        while data[at] != 0xFF:  # decoders skip stray bytes between segments, so must we
            at += 1
        while data[at] == 0xFF:
            at += 1
        marker = data[at]
        at += 1
        if marker in _JPEG_STANDALONE or marker == 0:
            continue
        if marker == _JPEG_END:
            return ImageHeader(width, height, complete=False)
        (length,) = struct.unpack_from(">H", data, at)
        if marker in _JPEG_FRAME:
            height, width = struct.unpack_from(">HH", data, at + 3)
        at += length
        if marker == _JPEG_SCAN:
            return ImageHeader(width, height, complete=data.rfind(b"\xff\xd9", at) >= 0)


def _parse_bmp(data: bytes) -> ImageHeader:
    offset, header_size = struct.unpack_from("<II", data, 10)
    if header_size == 12:  # OS/2 1.x
        width, height, _, bits = struct.unpack_from("<HHHH", data, 18)
        packing = 0
    else:
        width, height, _, bits, packing = struct.unpack_from("<iiHHI", data, 18)
    width, height = abs(width), abs(height)  # a negative height means rows from top to bottom
    run_length_coded = packing in (1, 2)
    row_bytes = (width * bits + 31) // 32 * 4
    return ImageHeader(width, height, complete=run_length_coded or len(data) >= offset + row_bytes * height)


def _parse_webp(data: bytes) -> ImageHeader:
    (riff_size,) = struct.unpack_from("<I", data, 4)
    complete = len(data) >= riff_size + 8
    kind = data[8:16]
    if kind == b"WEBPVP8X":  # extended: 24-bit canvas size minus one
        return ImageHeader(1 + _uint24(data, 24), 1 + _uint24(data, 27), complete)
    if kind == b"WEBPVP8L":  # lossless: two 14-bit sizes minus one behind a signature byte
        (bits,) = struct.unpack_from("<I", data, 21)
        return ImageHeader(1 + (bits & 0x3FFF), 1 + (bits >> 14 & 0x3FFF), complete)
    if kind == b"WEBPVP8 ":  # lossy: two 14-bit sizes behind the start code
        width, height = struct.unpack_from("<HH", data, 26)
        return ImageHeader(width & 0x3FFF, height & 0x3FFF, complete)
    raise ImageError("not a JPEG, PNG, BMP or WebP image (a RIFF file of another kind)")


def _uint24(data: bytes, at: int) -> int:
    low, high = struct.unpack_from("<HB", data, at)
    return int(low | high << 16)


_PARSERS: tuple[tuple[bytes, Callable[[bytes], ImageHeader]], ...] = (
    (b"\xff\xd8\xff", _parse_jpeg),
    (_PNG_SIGNATURE, _parse_png),
    (b"BM", _parse_bmp),
    (b"RIFF", _parse_webp),
)
