"""The machine that times were measured on, in one line."""

from __future__ import annotations

import os
import platform
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

_CPUINFO = Path("/proc/cpuinfo")


@dataclass(frozen=True, slots=True)
class Hardware:
    """Processor, how many of its cores the system shows, and the platform."""

    cpu: str
    cores: int
    platform: str

    @classmethod
    def here(cls) -> Hardware:
        """The machine that this runs on."""
        return cls(_cpu_model(), os.cpu_count() or 1, f"{platform.system()} {platform.machine()}")

    def __str__(self) -> str:
        return f"{self.cpu}, {self.cores} {'core' if self.cores == 1 else 'cores'}, {self.platform}, no GPU used"

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return asdict(self)


def _cpu_model() -> str:
    """As Linux tells it; elsewhere what Python knows."""
    try:
        lines = _CPUINFO.read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    for line in lines:
        key, _, value = line.partition(":")
        if key.strip() in ("model name", "Model") and value.strip():
            return " ".join(value.split())
    return platform.processor() or platform.machine() or "unknown processor"
