"""What to simulate: one garden, one camera, any number of sessions; read from TOML."""

from __future__ import annotations

import hashlib
import tomllib
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from andante.data import FloatArray, Trajectory
from andante.errors import ConfigError
from andante.simulator.camera import SimulatedCamera
from andante.simulator.conditions import Conditions
from andante.simulator.garden import Garden, GardenSpec, Scene
from andante.simulator.layout import make_garden
from andante.simulator.movables import MovableKind
from andante.simulator.odometry import OdometryNoise
from andante.simulator.settings import Settings
from andante.simulator.trajectories import BorderRun, Drive
from andante.simulator.visitors import Placed, placed_movables, put_down

_Seed = Annotated[int, Field(ge=0)]
_RECIPE = 1
"""Raised whenever the same plan gives other pictures than before."""


class Session(Settings):
    """One drive: where, under which conditions, with which visitors.

    ``seed`` decides about clouds, noise, odometry and the way; ``objects_seed`` about what the objects look like and
    where they are: sessions with the same one find them in the same places. It defaults to ``seed``. ``placed`` are
    put down exactly where they are told to be; ``objects`` that share a seed keep clear of those of all sessions.
    """

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$", max_length=100)]
    seed: _Seed = 0
    drive: Drive = BorderRun()
    conditions: Conditions = Conditions()
    objects: tuple[MovableKind, ...] = ()
    objects_seed: _Seed | None = None
    placed: tuple[Placed, ...] = ()
    odometry: OdometryNoise = OdometryNoise()
    start_time_s: Annotated[float, Field(ge=0)] = 1_600_000_000.0

    @model_serializer(mode="wrap")
    def _without_nothing_placed(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Where nothing is put down a session is told as ever, so that recordings of it keep their fingerprints."""
        values: dict[str, Any] = handler(self)
        if not self.placed:
            del values["placed"]
        return values

    def truth(self, garden: Garden) -> Trajectory:
        """The true poses of this drive; times begin at zero."""
        return self.drive.drive(garden, self.generator(0))

    def generator(self, purpose: int) -> np.random.Generator:
        """One random generator for each purpose, so that none depends on how much another was used."""
        return np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=(30, purpose)))


class Plan(Settings):
    """Sessions in one garden, seen by one camera; in TOML ``[garden]``, ``[camera]`` and one ``[[sessions]]`` each."""

    garden: GardenSpec = GardenSpec()
    camera: SimulatedCamera = SimulatedCamera()
    sessions: Annotated[tuple[Session, ...], Field(min_length=1)]

    @model_validator(mode="after")
    def _names_differ(self) -> Self:
        names = [session.name for session in self.sessions]
        if len(set(names)) < len(names):
            twice = next(name for name in names if names.count(name) > 1)
            raise ValueError(f"two sessions are called {twice!r}; give each its own name")
        return self

    @classmethod
    def from_toml(cls, path: str | Path) -> Plan:
        """Read a plan; raises ``ConfigError`` naming the key, the value and what is allowed."""
        try:
            values = tomllib.loads(Path(path).read_text(encoding="utf-8"))
        except OSError as error:
            raise ConfigError(f"plan {path} cannot be read: {error.strerror}; check the path") from None
        except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
            raise ConfigError(f"plan {path} is no valid TOML: {error}") from None
        return cls.checked(values, f"plan {path}")

    def session(self, name: str) -> Session:
        """A session by name; raises ``ConfigError`` for an unknown one."""
        for session in self.sessions:
            if session.name == name:
                return session
        known = ", ".join(session.name for session in self.sessions)
        raise ConfigError(f"there is no session {name!r} in this plan; it has {known}")

    def scene(self, name: str) -> Scene:
        """Everything there is to see in a session, in summer dress: the garden and its visitors."""
        session, garden = self.session(name), make_garden(self.garden)
        seed, sharing = self._objects_seed(session), self._sharing(session)
        placed = [one for other in sharing for one in other.placed]
        movables = placed_movables(garden, session.objects, seed, self._way(session, garden), placed)
        return Scene.of([*garden.things, *put_down(session.placed, seed), *movables])

    def fingerprint(self, name: str) -> str:
        """16 hex digits that change with everything that a session's recording depends on."""
        session = self.session(name)
        shared = self._sharing(session) if session.objects else []
        drives: list[object] = [(other.seed, other.drive.model_dump_json()) for other in shared]
        drives += [one.model_dump_json() for other in shared for one in other.placed]
        parts = (
            _RECIPE,
            self.garden.model_dump_json(),
            self.camera.model_dump_json(),
            session.model_dump_json(),
            drives,
        )
        return hashlib.sha256(repr(parts).encode()).hexdigest()[:16]

    def _objects_seed(self, session: Session) -> int:
        return session.seed if session.objects_seed is None else session.objects_seed

    def _way(self, session: Session, garden: Garden) -> FloatArray:
        """All points that visitors keep clear of: the ways of all sessions that share them, so that they stay put."""
        return np.concatenate([other.truth(garden).xy_m for other in self._sharing(session)])

    def _sharing(self, session: Session) -> list[Session]:
        """All sessions that find the same objects in the same places, this one among them."""
        seed = self._objects_seed(session)
        return [other for other in self.sessions if self._objects_seed(other) == seed]
