"""PoseNet: end-to-end regression of the pose, as the thesis compares with; needs the extra ``torch`` to learn."""

from andante.baselines.posenet.method import PoseNet as PoseNet
from andante.baselines.posenet.schedule import Schedule as Schedule
