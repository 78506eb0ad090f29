import numpy as np
import pytest

from andante.landmarks.turning import horizon_spectrum, turn_between


@pytest.mark.parametrize("turn", [0.0, 0.3, -1.2, 3.0])
def test_the_turn_is_what_the_panorama_shifted(scene, turn):
    before, after = (horizon_spectrum(scene.panorama(heading)) for heading in (0.4, 0.4 + turn))
    assert abs(np.angle(np.exp(1j * (turn_between(before, after) - turn)))) < 0.01


def test_brightness_is_no_turn(scene):
    panorama = scene.panorama(0.0)
    darker = (panorama * 0.5 + 20).astype(np.uint8)
    assert turn_between(horizon_spectrum(panorama), horizon_spectrum(darker)) == pytest.approx(0.0, abs=1e-9)
