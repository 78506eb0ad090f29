"""A map, images and odometry in, a pose at every moment out, and whether to believe it."""

from andante.localization.config import FaultConfig as FaultConfig
from andante.localization.config import JudgeConfig as JudgeConfig
from andante.localization.config import KalmanConfig as KalmanConfig
from andante.localization.config import MotionConfig as MotionConfig
from andante.localization.config import ParticleConfig as ParticleConfig
from andante.localization.config import SightingConfig as SightingConfig
from andante.localization.evidence import Evidence as Evidence
from andante.localization.evidence import evidence_of as evidence_of
from andante.localization.smoothing import FixedLagSmoother as FixedLagSmoother
from andante.localization.smoothing import Moment as Moment
from andante.localization.smoothing import smooth as smooth
from andante.localization.trackers import KalmanTracker as KalmanTracker
from andante.localization.trackers import ParticleTracker as ParticleTracker
from andante.localization.trackers import TrackerKind as TrackerKind
from andante.localization.trackers import make_tracker as make_tracker
