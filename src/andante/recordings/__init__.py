"""Files to restartable frames: one module per format, registered by name."""

from andante.recordings.content import picture_fingerprint
from andante.recordings.decode import decode_image, read_image
from andante.recordings.folder import FolderRecording, open_folder
from andante.recordings.frames import iterate_frames, map_frames
from andante.recordings.images import open_images
from andante.recordings.memory import MemoryRecording
from andante.recordings.parallel import decode_ordered, default_workers, ordered_map
from andante.recordings.registry import open_recording, register_format
from andante.recordings.thin import moving_frames
from andante.recordings.writer import write_recording

__all__ = [
    "FolderRecording",
    "MemoryRecording",
    "decode_image",
    "decode_ordered",
    "default_workers",
    "iterate_frames",
    "map_frames",
    "moving_frames",
    "open_folder",
    "open_images",
    "open_recording",
    "ordered_map",
    "picture_fingerprint",
    "read_image",
    "register_format",
    "write_recording",
]
