"""A panorama in, a feature vector out."""

from andante.features.fourier import FourierEncoder as FourierEncoder
from andante.features.fourier import fourier_magnitudes as fourier_magnitudes
from andante.features.illumination import Surroundings as Surroundings
from andante.features.illumination import orientation_channels as orientation_channels
from andante.features.illumination import patch_normalised as patch_normalised
from andante.features.illumination import window_px as window_px
from andante.features.network import NetworkEncoder as NetworkEncoder
from andante.features.patches import PatchEncoder as PatchEncoder
from andante.features.phase import PhaseEncoder as PhaseEncoder
from andante.features.pixels import PixelEncoder as PixelEncoder
