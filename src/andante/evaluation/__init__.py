"""Localizers on recordings: figures that can be trusted, and pages, tables and files that show them."""

from andante.evaluation.comparison import Evaluation as Evaluation
from andante.evaluation.comparison import Scored as Scored
from andante.evaluation.comparison import evaluate as evaluate
from andante.evaluation.figures import ErrorFigures as ErrorFigures
from andante.evaluation.figures import Figures as Figures
from andante.evaluation.figures import PlaceFigures as PlaceFigures
from andante.evaluation.figures import figures_of as figures_of
from andante.evaluation.files import write_csv as write_csv
from andante.evaluation.files import write_tum as write_tum
from andante.evaluation.report import write_report as write_report
from andante.evaluation.running import LocalizedFrame as LocalizedFrame
from andante.evaluation.running import Run as Run
from andante.evaluation.running import Skipped as Skipped
from andante.evaluation.running import run_localizer as run_localizer
from andante.evaluation.sections import Picture as Picture
from andante.evaluation.sections import Section as Section
from andante.evaluation.spatial import SpatialMaps as SpatialMaps
from andante.evaluation.spatial import axis_correlations as axis_correlations
from andante.evaluation.spatial import slow_feature_maps as slow_feature_maps
from andante.evaluation.spatial import sparse_code as sparse_code
from andante.evaluation.spatial import spatial_maps as spatial_maps
