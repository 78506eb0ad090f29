import numpy as np
import pytest

from andante.camera import PanoramaGeometry
from andante.errors import InputError
from andante.landmarks.boxes import Box
from andante.landmarks.examples import Examples, divided, gathered
from andante.landmarks.heatmaps import Grid
from andante.landmarks.labels import Labels

GRID = Grid(PanoramaGeometry(64, 16, 5.0, 60.0), 8)
BOX = Box(0.2, 0.5, 0.4, 0.4)


def test_only_what_labels_say_is_known(garden):
    monday, away = garden.drive(garden.loop(12), fisheye=True), garden.drive(garden.loop(40), fisheye=True, name="away")
    shed = Labels("shed", "monday", {0: BOX, 3: BOX}, frozenset({5}))
    tree = Labels("tree", "monday", {3: BOX}, anchors={3: Box(0.9, 0.5, 0.1, 0.1)})
    told = []
    names, examples = gathered(
        [(monday, [shed, tree])], [away], GRID, most=16, least=1, progress=lambda *step: told.append(step)
    )
    assert names == ["shed", "tree"]
    assert examples.panoramas.shape == (7, 16, 64, 3)  # frames 0, 3, 5, and a quarter of 16 from elsewhere
    assert examples.known.tolist() == [[True, False], [True, True], [True, False], *[[True, True]] * 4]
    assert examples.present.tolist() == [[True, False], [True, True], *[[False, False]] * 5]
    assert examples.source.tolist() == [0, 0, 0, 1, 1, 1, 1]
    assert np.allclose(examples.cells[1, 1], GRID.cells_of([BOX])[0])
    assert np.isfinite(examples.anchors[..., 0]).tolist() == [[False, False], [False, True], *[[False, False]] * 5]
    assert told[-1] == ("read", 7, 7)


def test_of_many_labels_some_are_used_evenly(garden):
    recording = garden.drive(garden.loop(40), fisheye=True)
    labels = Labels("shed", "monday", dict.fromkeys(range(40), BOX))
    _, examples = gathered([(recording, [labels])], [], GRID, most=5, least=1)
    assert len(examples) == 5


def test_nothing_that_is_held_out_borders_on_what_is_learnt():
    cells = np.zeros((400, 2, 4))
    cells[:200, 1] = np.nan  # the second landmark is only seen in the second half
    panoramas = np.arange(400, dtype=np.int64)[:, None, None, None]
    known = np.isfinite(cells[..., 0])
    examples = Examples(panoramas, cells, known, np.zeros(400, np.int64), cells)
    learning, held_out = divided(examples, 0.2)
    kept, held = learning.panoramas.ravel(), held_out.panoramas.ravel()
    blocks = [(32, 48), (112, 128), (192, 208), (272, 288), (352, 368)]
    blocks += [(216, 224), (256, 264), (296, 304), (336, 344), (376, 384)]
    assert set(held) == {frame for block in blocks for frame in range(*block)}
    assert np.abs(kept[:, None] - held[None, :]).min() > 1
    assert learning.present[:, 1].any()


def test_labels_that_cannot_be_used_are_refused(garden):
    recording = garden.drive(garden.loop(6), fisheye=True)
    with pytest.raises(InputError, match="no labels to learn from"):
        gathered([(recording, [])], [], GRID)
    with pytest.raises(InputError, match="has 1 labels in 'monday', at least 20"):
        gathered([(recording, [Labels("shed", "monday", {0: BOX})])], [], GRID)
