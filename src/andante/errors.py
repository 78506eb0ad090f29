"""Everything that Andante raises on purpose.

::

    AndanteError
    ├── InputError             what a user handed in cannot be used
    │   ├── ArrayError         numbers of a wrong shape or type, NaN (a ValueError as well)
    │   ├── ConfigError        an unknown key, a value outside its range
    │   ├── ImageError         one image: missing, truncated, too large, of a foreign size
    │   │   └── BlankImageError    it can be read but shows nothing
    │   └── RecordingError     a recording: its folder, table or time stamps
    ├── MapError               a map file: truncated, newer, tampered with
    ├── LearningError          data from which no slow features can be learnt
    ├── SessionRefusedError    a recording that would make the map worse that it is to be added to
    ├── NotFittedError         an estimator that is asked before it has learnt (a ValueError, an AttributeError)
    ├── LeakageError           an evaluation on data that the map was learnt from
    └── MissingExtraError      an optional dependency that is not installed

A message says what was wrong, what was found, what is allowed and what to do next, in one line.
"""

from __future__ import annotations


class AndanteError(Exception):
    """Base of all expected errors; the command line prints it as one line and exits with 1."""


class InputError(AndanteError):
    """What a user handed in cannot be used."""


class ArrayError(InputError, ValueError):
    """An array of a wrong shape or type, or with NaN; a ``ValueError`` as scikit-learn's conventions ask."""


class ConfigError(InputError):
    """An unknown key or a value outside its range."""


class ImageError(InputError):
    """One image cannot be used: missing, truncated, too large, of an unexpected shape."""


class BlankImageError(ImageError):
    """An image that can be read but shows nothing: black, burnt out, a covered lens."""


class RecordingError(InputError):
    """A recording cannot be used: its folder, its table or its time stamps."""


class MapError(AndanteError):
    """A map file cannot be used: truncated, from a newer schema, inconsistent."""


class LearningError(AndanteError):
    """The data does not allow learning: too few frames, no variance, no edges."""


class SessionRefusedError(AndanteError):
    """A recording does not fit the map that it is to be added to: wrong poses, another place, a robot that stood."""


class NotFittedError(AndanteError, ValueError, AttributeError):
    """An estimator is asked for something before it has learnt; the bases are scikit-learn's convention."""


class LeakageError(AndanteError):
    """An evaluation on a recording that the map was learnt from, without asking for training error."""


class MissingExtraError(AndanteError):
    """An optional dependency is not installed; the message names the install command."""

    def __init__(self, package: str, extra: str) -> None:
        super().__init__(package, extra)  # what pickle hands over when it comes out of another process

    def __str__(self) -> str:
        package, extra = self.args
        return f"{package} is not installed; install it with: pip install 'andante[{extra}]'"
