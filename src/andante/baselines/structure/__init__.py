"""Structure-based localizing, the opponent of thesis chapter 8: COLMAP makes points of pictures, a pose sees them."""

from andante.baselines.structure.keypoints import Keypoints as Keypoints
from andante.baselines.structure.keypoints import Sift as Sift
from andante.baselines.structure.localizer import PoseSearch as PoseSearch
from andante.baselines.structure.localizer import StructureLocalizer as StructureLocalizer
from andante.baselines.structure.matching import MatchRule as MatchRule
from andante.baselines.structure.method import Structure as Structure
