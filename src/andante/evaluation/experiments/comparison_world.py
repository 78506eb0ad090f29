"""What the comparison of thesis chapter 8 records: a border that is mapped, and drives along it and across the lawn."""

from __future__ import annotations

from andante.evaluation.experiments.plans import Scale
from andante.simulator import BorderRun, Conditions, GardenSpec, InfieldRun, Plan, Session, SimulatedCamera, make_garden

MAPPED_FRAMES, LAP_FRAMES, INFIELD_FRAMES = 1083, 284, 298
"""Of the thesis: mapped along the border, of a second run along it, and across the lawn."""
MAPPED, TEMPORAL, SPATIAL = "border", "border-later", "infield"
SEASONAL = ("border-autumn", "border-snow", "infield-autumn")

_SIZE_M = (15.0, 9.0)
_SPEED_M_S = 0.67


def comparison_plan(seed: int, scale: Scale) -> Plan:
    """A lap of a garden of 15 x 9 m in ``scale.frames`` images, and five drives that methods never see.

    At the thesis' scale mapped images are some 3.5 cm apart, as close as structure from pinhole views needs them.
    The second run along the border is half an hour later, under other clouds; the run across the lawn an hour later.
    With fewer frames than in the thesis these drives have fewer as well, spread over the same way.
    """
    garden = GardenSpec(seed=seed, size_x_m=_SIZE_M[0], size_y_m=_SIZE_M[1])
    length_m = make_garden(garden).border.inset(BorderRun().inset_m).length_m
    share = scale.frames / MAPPED_FRAMES
    lap, lawn = max(2, round(LAP_FRAMES * share)), max(2, round(INFIELD_FRAMES * share))

    def rate_hz(frames: float) -> float:
        """Of pictures, so many to a lap."""
        return frames * _SPEED_M_S / length_m

    def border(name: str, number: int, conditions: Conditions) -> Session:
        start = round(0.618 * number % 1, 3)
        return _session(seed, name, number, BorderRun(start=start, rate_hz=rate_hz(lap)), conditions)

    def infield(name: str, number: int, conditions: Conditions) -> Session:
        return _session(seed, name, number, InfieldRun(frames=lawn, rate_hz=rate_hz(lap)), conditions)

    mapped = BorderRun(rate_hz=rate_hz(scale.frames))
    side = scale.image_px
    return Plan(
        garden=garden,
        camera=SimulatedCamera(width_px=side, height_px=side),
        sessions=(
            _session(seed, MAPPED, 0, mapped, Conditions()),
            border(TEMPORAL, 1, Conditions(hour=11.5, sun_energy=5.2)),
            infield(SPATIAL, 2, Conditions(hour=12.0, sun_energy=5.0, clouds=0.35)),
            border(SEASONAL[0], 3, Conditions(season="autumn", hour=14.0)),
            border(SEASONAL[1], 4, Conditions(season="winter", hour=10.0, overcast=True)),
            infield(SEASONAL[2], 5, Conditions(season="autumn", hour=9.0, clouds=0.8)),
        ),
    )


def _session(seed: int, name: str, number: int, drive: BorderRun | InfieldRun, conditions: Conditions) -> Session:
    return Session(name=name, seed=seed * 100 + number, drive=drive, conditions=conditions)
