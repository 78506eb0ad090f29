"""One self-contained HTML page on an evaluation."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from andante.data import FloatArray, FrameInfo
from andante.errors import ImageError, InputError
from andante.evaluation.comparison import Evaluation
from andante.evaluation.figures import Figures
from andante.evaluation.files import write_text
from andante.evaluation.pages import render_page
from andante.evaluation.sections import Section, data_url
from andante.mapping import SlowMap
from andante.mapping.readout import LocalReadout
from andante.protocols import Recording

PAGE = "report.html"
_TEMPLATE = "report.html.j2"
_WORST = 10
_NOTHING = "–"

# Title -> key of the figures and number of decimals, none for a share.
METRES: dict[str, tuple[str, int | None]] = {
    "median error, m": ("median_m", 2),
    "mean error, m": ("mean_m", 2),
    "95 % error, m": ("p95_m", 2),
    "largest error, m": ("max_m", 2),
    "more than 1 m off": ("share_over_1m", None),
    "more than 3 m off": ("share_over_3m", None),
    "sure (ok) and more than 1 m off": ("confident_wrong_share", None),
}
HEADINGS: dict[str, tuple[str, int | None]] = {
    "median heading error, °": ("heading_median_deg", 1),
    "mean heading error, °": ("heading_mean_deg", 1),
    "95 % heading error, °": ("heading_p95_deg", 1),
    "largest heading error, °": ("heading_max_deg", 1),
}
_PLACES: dict[str, tuple[str, int | None]] = {
    "median error, places": ("median", 1),
    "mean error, places": ("mean", 1),
    "95 % error, places": ("p95", 1),
    "largest error, places": ("max", 0),
    "at most 1 place off": ("share_within_1", None),
    "at most 3 places off": ("share_within_3", None),
    "at most 10 places off": ("share_within_10", None),
}
COMMON: dict[str, tuple[str, int | None]] = {
    "lost or off the map": ("lost_share", None),
    "inside the 90 % radius": ("coverage_90", None),
    "ms per image": ("ms_per_image", 1),
}
_TILES = (
    *("median error, m", "95 % error, m", "more than 1 m off"),
    *("median error, places", "95 % error, places", "at most 3 places off"),
    *("lost or off the map", "ms per image"),
)


def write_report(
    evaluation: Evaluation, folder: str | Path, slowmap: SlowMap, sections: Sequence[Section] = ()
) -> Path:
    """Write ``report.html`` to a folder, which is made where it does not exist; gives the path of the page.

    ``sections`` stand before the figures. The page needs nothing but itself: plots and pictures are inside, there are
    no scripts. Raises ``InputError`` where it cannot be written.
    """
    return write_page(folder, render(evaluation, slowmap, sections))


def write_page(folder: str | Path, text: str) -> Path:
    """Write ``report.html`` and give its path; raises ``InputError``."""
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"report folder {folder} cannot be made: {error.strerror}; choose another place") from None
    write_text(folder / PAGE, text)
    return folder / PAGE


def render(evaluation: Evaluation, slowmap: SlowMap, sections: Sequence[Section] = ()) -> str:
    """The page as text."""
    return render_page(
        _TEMPLATE,
        map_name=slowmap.name,
        evaluation=evaluation,
        sections=sections,
        figures=evaluation.figures,
        tiles=_tiles(evaluation.figures),
        table=_table(evaluation),
        plots=_plots(evaluation, slowmap),
        worst=list(_worst(evaluation, slowmap)),
        folds=slowmap.calibration.folds,
        fold_kind=slowmap.calibration.kind,
        sources=slowmap.sources,
        conditions=conditions(evaluation.recording),
        config=json.dumps(slowmap.config.model_dump(mode="json"), indent=2),
        unit="places" if slowmap.unit == "place" else "m",
    )


def number(value: float | None, digits: int) -> str:
    """A number, or a dash."""
    return _NOTHING if value is None else f"{value:.{digits}f}"


def share(value: float | None) -> str:
    """A share as per cent."""
    if value is None:
        return _NOTHING
    # One frame in a thousand must not read as none.
    decimals = 1 if 0 < value < 0.1 or 0.9 < value < 1 else 0
    return f"{100 * value:.{decimals}f}\N{NO-BREAK SPACE}%"


def _texts(figures: Figures) -> dict[str, str]:
    """Every row of the table of figures: title -> text."""
    values = figures.as_dict()
    values |= values["places"] or {}
    headings = HEADINGS if figures.heading_median_deg is not None else {}
    return texts_of(values, (METRES if figures.places is None else _PLACES) | headings | COMMON)


def texts_of(values: Mapping[str, Any], rows: Mapping[str, tuple[str, int | None]]) -> dict[str, str]:
    """Values as a table shows them: title -> text, from title -> key and number of decimals, none for a share."""
    return {
        title: share(values[key]) if digits is None else number(values[key], digits)
        for title, (key, digits) in rows.items()
    }


def _tiles(figures: Figures) -> list[tuple[str, str]]:
    """The figures at the top of the page: caption and text."""
    texts = _texts(figures)
    return [(title, texts[title]) for title in _TILES if title in texts]


def _table(evaluation: Evaluation) -> dict[str, list[str]]:
    """Rows of the comparison: title -> the texts of all localizers."""
    columns = [_texts(one.figures) for one in (evaluation.map, *evaluation.others)]
    return {title: [texts.get(title, _NOTHING) for texts in columns] for title in columns[0]}


def _plots(evaluation: Evaluation, slowmap: SlowMap) -> list[dict[str, str]]:
    if not evaluation.figures.n_errors:
        return []
    from andante.evaluation import plots, status_plots

    metric, covered = evaluation.unit == "m", evaluation.figures.coverage_90
    return shown_plots(
        ("Where" if metric else "Which place", plots.trajectory(evaluation, mapped_places(slowmap))),
        ("Error and status over time", status_plots.timeline(evaluation.map, evaluation.unit)),
        ("How often how wrong", plots.distribution(evaluation)),
        (f"Predicted radius: {share(covered)} of the answers lie within it", status_plots.calibration(evaluation.map)),
    )


def shown_plots(*drawn: tuple[str, str | None]) -> list[dict[str, str]]:
    """Titles and SVG texts as the page shows them; those that there is nothing for are left out."""
    return [{"title": title, "image": data_url("image/svg+xml", svg.encode())} for title, svg in drawn if svg]


def mapped_places(slowmap: SlowMap) -> FloatArray:
    """Positions (r, 2) that the map keeps; none where its readout is a formula."""
    return slowmap.readout.xy if isinstance(slowmap.readout, LocalReadout) else np.empty((0, 2))


def _worst(evaluation: Evaluation, slowmap: SlowMap) -> Iterator[dict[str, Any]]:
    """The frames with the largest errors, as the table shows them."""
    errors = evaluation.map.errors
    slowmap = slowmap.for_recording(evaluation.recording)
    start_s = evaluation.run.frames[0].info.timestamp_s if evaluation.run.frames else 0.0
    largest_first = np.argsort(-np.nan_to_num(errors, nan=-1.0), kind="stable")[:_WORST]
    for index in largest_first[np.isfinite(errors[largest_first])]:
        frame = evaluation.run.frames[int(index)]
        yield {
            "picture": _thumbnail(slowmap, evaluation.recording, frame.info),
            "image": frame.info.image,
            "time": f"{frame.info.timestamp_s - start_s:.1f}",
            "error": number(float(errors[index]), 2 if evaluation.unit == "m" else 0),
            "status": str(frame.estimate.status),
            "reason": frame.estimate.reason,
        }


def _thumbnail(slowmap: SlowMap, recording: Recording, info: FrameInfo) -> str | None:
    """The panorama that the map saw; none where the picture is gone."""
    try:
        panorama = slowmap.front_end.panorama(recording.load(info))
    except ImageError:
        return None
    _, data = cv2.imencode(".jpg", panorama, [cv2.IMWRITE_JPEG_QUALITY, 80])
    return data_url("image/jpeg", data.tobytes())


def conditions(recording: Recording) -> list[tuple[str, str]]:
    """What a recording says of its conditions, as text."""
    return [(key, str(value)) for key, value in recording.conditions.items()]
