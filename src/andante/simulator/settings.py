"""The base of everything that a plan can say: frozen, unknown keys are errors, one-line messages."""

from __future__ import annotations

from typing import Self

from pydantic import BaseModel, ConfigDict, ValidationError

from andante.errors import ConfigError


class Settings(BaseModel):
    """Frozen values, checked when they are made; raises ``ConfigError`` naming key, value and what is allowed."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    def __init__(self, **values: object) -> None:
        try:
            super().__init__(**values)
        except ValidationError as error:
            raise ConfigError(one_line(error, type(self))) from None

    @classmethod
    def checked(cls, values: object, source: str) -> Self:
        """From plain values, such as a TOML file gives; ``source`` begins the message of a ``ConfigError``."""
        try:
            return cls.model_validate(values)
        except ValidationError as error:
            raise ConfigError(f"{source}: {one_line(error, cls)}") from None


def one_line(error: ValidationError, model: type[BaseModel]) -> str:
    """The first fault in words: which key, what was got, what is allowed."""
    fault = error.errors(include_url=False)[0]
    key = ".".join(str(part) for part in fault["loc"]) or "value"
    if fault["type"] == "extra_forbidden":
        return (
            f"unknown key {key!r}; remove it or check its spelling (known at the top: {', '.join(model.model_fields)})"
        )
    if fault["type"] == "missing":
        return f"{key!r} is missing; add it"
    return f"{key} = {str(fault['input'])[:80]!r} is not allowed: {fault['msg'].lower()}"
