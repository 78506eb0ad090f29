"""Which frames belong together: edges for slow feature analysis, and where frames are if only odometry tells.

Slow features vary little along edges (Escalante-B. and Wiskott, JMLR 14, 2013), so choosing edges is choosing what
they ignore. ``temporal_edges``: what changes from frame to frame. ``place_edges`` and ``label_edges``: everything
that differs between visits of one place, such as light and season. ``restructured_edges`` and
``loop_closure_edges``: the thesis' way to the same end, a reordered sequence (6.2 and 6.1).

Edges between drives need positions in one frame. Where only each drive's own odometry is known, ``register_sessions``
gives them: every drive is closed on itself (``find_loop_closures``, ``close_wire_loop``), frames of the same places are
found by features (``align_sequences``), and the drives are laid over each other (``fit_similarity``, ``fit_path``).
"""

from andante.sequences.alignment import Correspondences, align_sequences
from andante.sequences.closure import ClosedLoop, close_wire_loop
from andante.sequences.places import label_edges, place_edges
from andante.sequences.pose_graph import Anchors, Closures, DriftNoise, FittedPath, fit_path
from andante.sequences.registration import Registration, fit_similarity
from andante.sequences.restructured import (
    loop_closure_edges,
    loop_closure_order,
    restructured_edges,
    restructured_order,
)
from andante.sequences.revisits import Revisits, find_loop_closures
from andante.sequences.sessions import RegisteredSession, SessionReport, register_session, register_sessions
from andante.sequences.temporal import temporal_edges

__all__ = [
    "Anchors",
    "ClosedLoop",
    "Closures",
    "Correspondences",
    "DriftNoise",
    "FittedPath",
    "RegisteredSession",
    "Registration",
    "Revisits",
    "SessionReport",
    "align_sequences",
    "close_wire_loop",
    "find_loop_closures",
    "fit_path",
    "fit_similarity",
    "label_edges",
    "loop_closure_edges",
    "loop_closure_order",
    "place_edges",
    "register_session",
    "register_sessions",
    "restructured_edges",
    "restructured_order",
    "temporal_edges",
]
