"""The base of everything that a plan can say: frozen, unknown keys are errors, one-line messages."""

from __future__ import annotations

from typing import Any, Self, get_args

from pydantic import BaseModel, ConfigDict, ValidationError

from andante.errors import ConfigError


class Settings(BaseModel):
    """Frozen values, checked when they are made; raises ``ConfigError`` naming key, value and what is allowed."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    def __init__(self, **values: object) -> None:
        try:
            super().__init__(**values)
        except ValidationError as error:
            raise ConfigError(_one_line(error, type(self))) from None

    # Tells pydantic not to call this for values inside of others: only the outermost knows the whole key.
    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]

    @classmethod
    def checked(cls, values: object, source: str) -> Self:
        """From plain values, such as a TOML file gives; ``source`` begins the message of a ``ConfigError``."""
        try:
            return cls.model_validate(values)
        except ValidationError as error:
            raise ConfigError(f"{source}: {_one_line(error, cls)}") from None


def _one_line(error: ValidationError, model: type[BaseModel]) -> str:
    """The first fault in words: which key, what was got, what is allowed."""
    fault = error.errors(include_url=False)[0]
    key = ".".join(str(part) for part in fault["loc"]) or "value"
    if fault["type"] == "extra_forbidden":
        return f"unknown key {key!r}; allowed here are {', '.join(_keys_at(model, fault['loc'][:-1]))}"
    if fault["type"] == "missing":
        return f"{key!r} is missing; add it"
    return f"{key} = {str(fault['input'])[:80]!r} is not allowed: {fault['msg'].lower()}"


def _keys_at(model: type[BaseModel], location: tuple[int | str, ...]) -> list[str]:
    """The keys that a part of the configuration may have; numbers in ``location`` are positions in lists."""
    models = [model]
    for part in location:
        if isinstance(part, int):
            continue
        fields = [each.model_fields[part] for each in models if part in each.model_fields]
        if fields:
            models = _models_in(fields[0].annotation)
        else:  # the kind of a drive chooses among several models
            models = [each for each in models if (kind := each.model_fields.get("kind")) and kind.default == part]
    return sorted({name for each in models for name in each.model_fields})


def _models_in(annotation: Any) -> list[type[BaseModel]]:  # noqa: ANN401  (annotations have no common type)
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [found for part in get_args(annotation) for found in _models_in(part)]
