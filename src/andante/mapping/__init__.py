"""Recordings and a configuration in, a map out."""

from andante.mapping.builder import BuildLog as BuildLog
from andante.mapping.builder import Progress as Progress
from andante.mapping.builder import build_map as build_map
from andante.mapping.config import MapConfig as MapConfig
from andante.mapping.frontend import FrontEnd as FrontEnd
from andante.mapping.slow_map import SlowMap as SlowMap
from andante.mapping.slow_map import Source as Source
