"""Other ways to a position, which a map of slow features has to beat: on its own features, and by other means."""

from andante.baselines.baseline import Baseline as Baseline
from andante.baselines.embedding import Embedding as Embedding
from andante.baselines.gaussian_process import GaussianProcess as GaussianProcess
from andante.baselines.maps import MapLocalizer as MapLocalizer
from andante.baselines.maps import MapMethod as MapMethod
from andante.baselines.method import Learned as Learned
from andante.baselines.method import Method as Method
from andante.baselines.method import StagedLocalizer as StagedLocalizer
from andante.baselines.methods import METHODS as METHODS
from andante.baselines.methods import MethodOptions as MethodOptions
from andante.baselines.methods import default_methods as default_methods
from andante.baselines.methods import known_methods as known_methods
from andante.baselines.methods import make_methods as make_methods
from andante.baselines.nearest import NearestNeighbours as NearestNeighbours
from andante.baselines.posenet import PoseNet as PoseNet
from andante.baselines.principal import PrincipalComponents as PrincipalComponents
from andante.baselines.ridge import RidgeRegression as RidgeRegression
from andante.baselines.suite import fit_baselines as fit_baselines
from andante.baselines.thumbnails import ThumbnailMethod as ThumbnailMethod
from andante.baselines.training import Training as Training
from andante.baselines.training import training_frames as training_frames
from andante.baselines.training import training_recordings as training_recordings
