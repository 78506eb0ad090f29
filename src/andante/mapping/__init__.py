"""Recordings and a configuration in, a map out."""

from andante.mapping.builder import build_map as build_map
from andante.mapping.builder import learn_map as learn_map
from andante.mapping.config import MapConfig as MapConfig
from andante.mapping.frontend import FrontEnd as FrontEnd
from andante.mapping.landmark_builder import add_landmarks as add_landmarks
from andante.mapping.landmark_builder import map_landmarks as map_landmarks
from andante.mapping.landmark_config import LandmarkConfig as LandmarkConfig
from andante.mapping.landmarks import LandmarkMap as LandmarkMap
from andante.mapping.living import Trial as Trial
from andante.mapping.living import merge_maps as merge_maps
from andante.mapping.living import update_map as update_map
from andante.mapping.memory import MappedSession as MappedSession
from andante.mapping.memory import Source as Source
from andante.mapping.sessions import BuildLog as BuildLog
from andante.mapping.sessions import Progress as Progress
from andante.mapping.sessions import encode_session as encode_session
from andante.mapping.slow_map import SlowMap as SlowMap
