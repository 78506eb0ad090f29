"""Landmarks: boxes in an image, and the views that are cut out around them."""

from andante.landmarks.boxes import Box as Box
from andante.landmarks.boxes import Detection as Detection
from andante.landmarks.views import ViewCutter as ViewCutter
from andante.landmarks.views import ViewWindow as ViewWindow
from andante.landmarks.views import largest_window as largest_window
