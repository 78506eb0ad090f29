"""Templates to pages that need nothing but themselves."""

from __future__ import annotations

from importlib.metadata import version
from importlib.resources import files


def render_page(template: str, **values: object) -> str:
    """The page of a template in this room as text; it also gets the ``version`` of the package."""
    # It costs more time to import than most commands take.
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    environment = Environment(
        loader=FunctionLoader(_source),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    return environment.get_template(template).render(**values, version=version("andante"))


def _source(name: str) -> str:
    return files("andante.evaluation").joinpath(name).read_text(encoding="utf-8")
