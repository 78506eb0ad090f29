"""An experiment from its name to its files."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from andante.errors import InputError
from andante.evaluation.experiments.cache import code_hash, default_cache
from andante.evaluation.experiments.outcome import Cell, Experiment, Outcome, Plot, Table
from andante.evaluation.experiments.plans import Scale
from andante.evaluation.experiments.registry import DEFAULT_SEED, experiment_named
from andante.evaluation.experiments.trials import Bench
from andante.evaluation.files import write_bytes, write_text
from andante.evaluation.pages import render_page
from andante.evaluation.sections import data_url
from andante.simulator import Plan, Progress

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ScaleName = Literal["small", "thesis"]


@dataclass(frozen=True)
class Written:
    """A finished experiment and its files: figures as JSON, plots as PNG, and a page with everything."""

    experiment: Experiment
    outcome: Outcome
    values: Mapping[str, Any]
    json: Path
    plots: tuple[Path, ...]
    page: Path

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON: what is in the file of figures, and where the files are."""
        files = {"json": str(self.json), "plots": [str(plot) for plot in self.plots], "page": str(self.page)}
        return {**self.values, "files": files}


def run_experiment(
    name: str,
    folder: str | Path,
    *,
    scale: ScaleName | Scale = "small",
    cache: str | Path | None = None,
    seed: int | None = None,
    workers: int = 1,
    progress: Progress | None = None,
) -> Written:
    """Record, learn, localize, and write ``NAME.json``, ``NAME.png`` and ``NAME.html`` to a folder.

    ``cache`` (default: ``default_cache()``) keeps rendered sessions and finished trials, so that a killed run goes on
    where it was. Raises ``InputError`` for an unknown experiment or a place that cannot be written, and as
    ``render_sessions`` and ``build_map`` do.
    """
    experiment, folder = experiment_named(name), Path(folder)
    seed = DEFAULT_SEED if seed is None else seed
    sizes = scale if isinstance(scale, Scale) else experiment.small if scale == "small" else experiment.full
    plan = experiment.plan(seed, sizes)
    _make(folder)
    bench = Bench(plan, default_cache() if cache is None else Path(cache), workers=workers, progress=progress)
    outcome = experiment.run(bench, seed, sizes)
    values = _values(experiment, plan, outcome, seed, sizes)
    return _write(experiment, outcome, values, folder)


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"folder {folder} cannot be made: {error.strerror}; choose another place") from None


def _values(experiment: Experiment, plan: Plan, outcome: Outcome, seed: int, scale: Scale) -> dict[str, Any]:
    """Everything that is needed to understand the figures and to make them again."""
    return {
        "experiment": experiment.name,
        "title": experiment.title,
        "source": f"thesis {experiment.source}",
        "thesis": experiment.thesis,
        "version": version("andante"),
        "code": code_hash(),
        "seed": seed,
        "scale": scale.model_dump(),
        "figures": outcome.figures,
        "notes": list(outcome.notes),
        "configurations": {one.name: one.config.model_dump(mode="json") for one in outcome.contenders},
        "plan": plan.model_dump(mode="json"),
        "fingerprints": {session.name: plan.fingerprint(session.name) for session in plan.sessions},
    }


def _write(experiment: Experiment, outcome: Outcome, values: Mapping[str, Any], folder: Path) -> Written:
    pictures = [(plot, _png(plot.figure)) for plot in outcome.plots]
    paths = [folder / f"{'-'.join(filter(None, (experiment.name, plot.suffix)))}.png" for plot in outcome.plots]
    for path, (_, png) in zip(paths, pictures, strict=True):
        write_bytes(path, png)
    facts, page = folder / f"{experiment.name}.json", folder / f"{experiment.name}.html"
    write_text(facts, json.dumps(values, indent=1, allow_nan=False) + "\n")
    write_text(page, _page(experiment, outcome, values, pictures))
    return Written(experiment, outcome, values, facts, tuple(paths), page)


def _png(figure: Figure) -> bytes:
    data = io.BytesIO()
    figure.savefig(data, format="png", dpi=160, facecolor="white", metadata={"Software": None})
    return data.getvalue()


def _page(
    experiment: Experiment, outcome: Outcome, values: Mapping[str, Any], pictures: list[tuple[Plot, bytes]]
) -> str:
    return render_page(
        "experiment.html.j2",
        experiment=experiment,
        scale=", ".join(f"{value} {name}" for name, value in values["scale"].items()),
        seed=values["seed"],
        notes=outcome.notes,
        plots=[{"caption": plot.caption, "url": data_url("image/png", png)} for plot, png in pictures],
        tables=[_as_text(table) for table in outcome.tables],
        config=json.dumps(values["configurations"], indent=2),
        plan=json.dumps(values["plan"], indent=2),
    )


def _as_text(table: Table) -> dict[str, Any]:
    rows = [[_text(cell) for cell in row] for row in table.rows]
    return {"title": table.title, "columns": table.columns, "rows": rows, "verdict": table.verdict}


def _text(cell: Cell) -> str:
    if cell is None:
        return "–"
    return f"{cell:.3f}" if isinstance(cell, float) else str(cell)
