import pytest

from andante.errors import ConfigError, RecordingError
from andante.recordings import open_recording, register_format, registry


def test_opens_the_folder_format_by_default(make_folder):
    folder = make_folder(2)
    assert open_recording(folder).name == open_recording(str(folder), "folder").name == "monday"


def test_a_plain_folder_of_images_only_when_asked(make_folder):
    images = make_folder(2) / "images"
    with pytest.raises(RecordingError, match=r'recording\.toml is missing; .* ask for format="images"'):
        open_recording(images)
    assert len(open_recording(images, format="images").infos) == 2


def test_formats_are_registered_by_name(monkeypatch, make_folder):
    monkeypatch.setattr(registry, "_OPENERS", dict(registry._OPENERS))
    register_format("parent", lambda path: open_recording(path.parent))
    assert open_recording(make_folder(2) / "frames.csv", "parent").name == "monday"
    with pytest.raises(ConfigError, match="format 'parent' is registered already"):
        register_format("parent", open_recording)


def test_unknown_format(tmp_path):
    with pytest.raises(ConfigError, match="format 'bag' of recordings is unknown; allowed are folder, images"):
        open_recording(tmp_path, "bag")
