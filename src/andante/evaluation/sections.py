"""Parts that a report may have besides its figures: text, pictures, a table."""

from __future__ import annotations

import base64
from dataclasses import dataclass

import cv2

from andante.data import ImageArray


@dataclass(frozen=True, slots=True)
class Picture:
    """A caption and an image as a data URL, so that the page needs no other file."""

    caption: str
    url: str

    @classmethod
    def of_svg(cls, caption: str, text: str) -> Picture:
        """From the text of an SVG."""
        return cls(caption, data_url("image/svg+xml", text.encode()))

    @classmethod
    def of_image(cls, caption: str, image: ImageArray) -> Picture:
        """From grey (height, width) or BGR (height, width, 3), as a JPEG."""
        _, jpeg = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, 85])
        return cls(caption, data_url("image/jpeg", jpeg.tobytes()))


@dataclass(frozen=True, slots=True)
class Section:
    """A heading with what stands below it; the first column of ``rows`` names them, the others are numbers."""

    title: str
    text: str = ""
    pictures: tuple[Picture, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()


def data_url(kind: str, data: bytes) -> str:
    """A file inside of a page."""
    return f"data:{kind};base64,{base64.b64encode(data).decode()}"
