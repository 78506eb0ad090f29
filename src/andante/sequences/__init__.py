"""Which frames belong together: edges for slow feature analysis, from times, positions and labels alone.

Slow features vary little along edges (Escalante-B. and Wiskott, JMLR 14, 2013), so choosing edges is choosing what
they ignore. ``temporal_edges``: what changes from frame to frame. ``place_edges`` and ``label_edges``: everything
that differs between visits of one place, such as light and season. ``restructured_edges`` and
``loop_closure_edges``: the thesis' way to the same end, a reordered sequence (6.2 and 6.1).
"""

from andante.sequences.places import label_edges, place_edges
from andante.sequences.restructured import (
    loop_closure_edges,
    loop_closure_order,
    restructured_edges,
    restructured_order,
)
from andante.sequences.temporal import temporal_edges

__all__ = [
    "label_edges",
    "loop_closure_edges",
    "loop_closure_order",
    "place_edges",
    "restructured_edges",
    "restructured_order",
    "temporal_edges",
]
