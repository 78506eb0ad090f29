"""What a tracker assumes of a robot and its images: frozen nested values, every field has a default."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from andante.errors import ConfigError

_Positive = Annotated[float, Field(gt=0)]
_Share = Annotated[float, Field(ge=0, le=1)]
_Floor = Annotated[float, Field(ge=1e-6, le=1)]


class _Frozen(BaseModel):
    """Checked when it is made; raises ``ConfigError`` naming the key and what is allowed."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    def __init__(self, **values: object) -> None:
        try:
            super().__init__(**values)
        except ValidationError as error:
            fault = error.errors(include_url=False)[0]
            key = ".".join(str(part) for part in fault["loc"]) or "value"
            raise ConfigError(
                f"tracker configuration: {key} = {fault['input']!r:.80} is not allowed: {fault['msg'].lower()}"
            ) from None

    # Tells pydantic not to call this for values inside of others: only the outermost knows the whole key.
    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]


class MotionConfig(_Frozen):
    """What odometry is worth, and how fast a robot can be.

    ``scale`` and ``gyro_rad_s`` are deviations of what stays the same for long, the error of the wheels' size and the
    bias of the gyro; ``wheel_m`` grows with the square root of the way in metres and ``turn_rad`` with that of the
    turn. Wheels slip in a ``slip_share`` of all steps. A step faster than ``max_speed_m_s`` or ``max_turn_rad_s`` is
    no motion but a jump. Where odometry is missing the robot walks at random, ``walk_m`` and ``walk_rad`` in a second.
    """

    scale: _Positive = 0.015
    gyro_rad_s: _Positive = 0.004
    wheel_m: _Positive = 0.015
    turn_rad: _Positive = 0.02
    slip_share: _Share = 0.3
    max_speed_m_s: _Positive = 2.5
    max_turn_rad_s: _Positive = 20.0
    walk_m: _Positive = 0.4
    walk_rad: _Positive = 0.8


class SightingConfig(_Frozen):
    """What an image, or a fix, is worth.

    An image may be wrong altogether: however far a place is from all it names, ``floor`` of the likelihood is left, for
    images whose status is ok, degraded, lost and off the map. Images that are taken close to each other err alike, so
    one counts in full only after ``correlation_m`` of way, or as much of a turn as ``correlation_rad``; gross errors
    pass sooner, so that which place it is may be decided after ``decision_m``. ``min_sigma_m`` and ``max_sigma_m``
    bound how exact one image is taken to be, ``blind_sigma_m`` is the deviation of images that name places without a
    pose, ``heading_sigma_rad`` that of headings that come without one.
    """

    floor_ok: _Floor = 0.02
    floor_degraded: _Floor = 0.1
    floor_lost: _Floor = 0.5
    floor_off_map: _Floor = 0.9
    correlation_m: _Positive = 0.8
    correlation_rad: _Positive = 2.0
    decision_m: _Positive = 0.2
    min_sigma_m: _Positive = 0.02
    max_sigma_m: _Positive = 0.12
    blind_sigma_m: _Positive = 0.3
    heading_sigma_rad: _Positive = 0.1


class JudgeConfig(_Frozen):
    """When a pose is believed.

    Images that agree with the prediction, each a little way (``fresh_m``) after the one before, earn a point, others
    that disagree cost one. Ok begins at ``trusted_points`` with a radius of at most ``ok_radius_m``; a pose is lost at
    zero points or beyond ``lost_radius_m``. Without an image that is sure, ok lasts for ``unconfirmed_m`` of way and
    ``unconfirmed_s``. It ends where rivals have more than ``rival_share`` of the weight, where images lie more than
    ``misfit_m`` off the shape of the way, and where fewer than ``agreement`` of them agree. ``gate`` (with ``slack_m``
    and ``slack_rad`` for what neither knows) is the squared Mahalanobis distance up to which an image agrees; what is
    ``far_m`` away is another place.
    """

    trusted_points: Annotated[int, Field(ge=1)] = 4
    max_points: Annotated[int, Field(ge=1)] = 6
    fresh_m: _Positive = 0.03
    ok_radius_m: _Positive = 0.8
    lost_radius_m: _Positive = 3.0
    unconfirmed_m: _Positive = 0.6
    unconfirmed_s: _Positive = 3.0
    rival_share: _Share = 0.15
    gate: _Positive = 9.21
    slack_m: _Positive = 0.1
    slack_rad: _Positive = 0.1
    far_m: _Positive = 0.7
    misfit_m: _Positive = 0.22
    agreement: _Share = 0.6


class FaultConfig(_Frozen):
    """When a step in slow-feature space is a jump.

    It is where it exceeds the usual one by ``spreads`` times the usual deviation from that, at least by
    ``least_factor``, once ``warm_up`` steps are known; the last ``memory`` or so are remembered.
    """

    spreads: _Positive = 4.0
    least_factor: Annotated[float, Field(gt=1)] = 2.0
    memory: Annotated[int, Field(ge=2)] = 200
    warm_up: Annotated[int, Field(ge=1)] = 15


class ParticleConfig(_Frozen):
    """The particle filter: how many there are, when they are drawn anew, and how many images may inject."""

    particles: Annotated[int, Field(ge=50, le=100_000)] = 800
    resample_below: _Share = 0.5
    injected_share: _Share = 0.15
    injected_weight: _Share = 0.3
    roughening_m: _Positive = 0.005
    roughening_rad: _Positive = 0.005
    cluster_m: _Positive = 0.5
    motion: MotionConfig = MotionConfig()
    sighting: SightingConfig = SightingConfig()
    judge: JudgeConfig = JudgeConfig()
    fault: FaultConfig = FaultConfig()


class KalmanConfig(_Frozen):
    """The extended Kalman filter: a gate (99 % of two degrees of freedom), and when to begin again."""

    gate: _Positive = 9.21
    rejections: Annotated[int, Field(ge=2)] = 3
    motion: MotionConfig = MotionConfig()
    sighting: SightingConfig = SightingConfig()
    judge: JudgeConfig = JudgeConfig()
    fault: FaultConfig = FaultConfig()
