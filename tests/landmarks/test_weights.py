import hashlib
from http.client import IncompleteRead

import pytest

from andante.errors import InputError
from andante.landmarks import weights as module
from andante.landmarks.weights import default_weights, fetched_weights

RELEASED = b"as released"


@pytest.fixture
def pinned(monkeypatch):
    monkeypatch.setattr(module, "SHA256", hashlib.sha256(RELEASED).hexdigest())


@pytest.mark.usefixtures("pinned")
def test_weights_are_fetched_once_and_again_where_they_are_damaged(tmp_path):
    asked = []

    def fetch(url):
        asked.append(url)
        return RELEASED

    path = tmp_path / "cache" / "weights.onnx"
    for _ in range(2):
        assert fetched_weights(path, fetch).read_bytes() == RELEASED
    assert asked == [module.URL]
    path.write_bytes(b"damaged")
    assert fetched_weights(path, fetch).read_bytes() == RELEASED
    assert len(asked) == 2


@pytest.mark.usefixtures("pinned")
def test_another_checksum_is_not_kept(tmp_path):
    with pytest.raises(InputError, match=r"has the SHA-256 .* it was not kept: .*--weights FILE"):
        fetched_weights(tmp_path / "a.onnx", lambda url: b"something else")
    assert not list(tmp_path.iterdir())


def test_without_a_network_the_message_says_what_to_do(tmp_path, monkeypatch):
    def refused(*_, **__):
        raise OSError("no route")

    def cut_short(*_, **__):
        raise IncompleteRead(b"half")

    for urlopen, reason in ((refused, "no route"), (cut_short, "IncompleteRead")):
        monkeypatch.setattr(module.urllib.request, "urlopen", urlopen)
        with pytest.raises(InputError, match=rf"downloaded from https://github.com/.*{reason}.*--weights FILE"):
            fetched_weights(tmp_path / "a.onnx")


def test_the_release_is_pinned():
    assert module.URL.startswith("https://github.com/Megvii-BaseDetection/YOLOX/releases/download/0.1.1rc0/")
    assert len(module.SHA256) == 64


def test_the_cache_follows_the_users_choice(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert default_weights() == tmp_path / "andante" / "weights" / "yolox_nano.onnx"
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    assert default_weights().is_absolute()
