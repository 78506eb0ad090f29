"""Other ways from the map's own features to a position: what a map of slow features has to beat."""

from andante.baselines.baseline import Baseline as Baseline
from andante.baselines.embedding import Embedding as Embedding
from andante.baselines.nearest import NearestNeighbours as NearestNeighbours
from andante.baselines.posenet import PoseNet as PoseNet
from andante.baselines.principal import PrincipalComponents as PrincipalComponents
from andante.baselines.ridge import RidgeRegression as RidgeRegression
from andante.baselines.suite import fit_baselines as fit_baselines
from andante.baselines.training import Training as Training
from andante.baselines.training import training_frames as training_frames
from andante.baselines.training import training_recordings as training_recordings
