"""Under which conditions a garden is seen: season, light, weather, camera noise."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from andante.simulator.settings import Settings

Season = Literal["spring", "summer", "autumn", "winter"]
_Share = Annotated[float, Field(ge=0, le=1)]


class Conditions(Settings):
    """What may differ between two recordings of one garden; the ranges of the light are those of thesis 4.1.

    ``sun_energy`` is the strength of the light, ``sun_y_m`` moves it along y, ``sun_red`` is its red channel;
    ``hour`` moves it along x and towards the horizon. ``clouds`` is how much of the sky they cover; ``overcast``
    hides the sun. ``drift_energy`` is the relative change of the sun from the first to the last frame of a recording
    and ``drift_hours`` how far time goes on meanwhile (slow change of light, thesis 6.3.1). ``exposure`` scales
    what the sensor collects; ``noise`` is its standard deviation in grey levels of 255.
    """

    season: Season = "summer"
    hour: Annotated[float, Field(ge=7, le=17)] = 11.0
    sun_energy: Annotated[float, Field(ge=3, le=8)] = 5.5
    sun_y_m: Annotated[float, Field(ge=-10, le=10)] = 4.0
    sun_red: Annotated[float, Field(ge=0.5, le=1)] = 0.8
    clouds: _Share = 0.45
    overcast: bool = False
    drift_energy: Annotated[float, Field(ge=-0.9, le=2)] = 0.0
    drift_hours: Annotated[float, Field(ge=-4, le=4)] = 0.0
    exposure: Annotated[float, Field(ge=0.1, le=5)] = 1.0
    noise: Annotated[float, Field(ge=0, le=50)] = 1.5
