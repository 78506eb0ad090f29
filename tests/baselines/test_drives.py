import numpy as np
import pytest

from andante.baselines.drives import read_drives
from andante.baselines.posenet.pictures import front_end_of
from andante.data import Pose2D
from andante.errors import RecordingError
from andante.recordings import MemoryRecording


def read(drives, positions="reference", **kwargs):
    return read_drives(drives, front_end_of(drives[0], 64, 12, (3, 50)), positions, **kwargs)


def test_frames_come_one_drive_after_the_other(make_drive):
    first, second = make_drive(1, standing=[7], unknown=[3, 4]), make_drive(2)
    drives = read([first, second])
    assert drives.panoramas.shape == (37 + 40, 12, 64)
    assert drives.skipped == 0
    np.testing.assert_array_equal(drives.panoramas[0], first.load(first.infos[0]))
    np.testing.assert_array_equal(drives.panoramas[37], second.load(second.infos[0]))
    assert drives.xy[38] == pytest.approx([second.infos[1].reference.x_m, second.infos[1].reference.y_m])
    assert np.isnan(drives.heading).all()


def test_headings_belong_to_their_pictures(garden):
    drive = garden.drive(garden.loop(30))
    drives = read([drive])
    assert drives.heading == pytest.approx([info.reference.heading_rad for info in drive.infos])


def test_what_shows_nothing_is_counted_and_told(make_drive):
    told = []
    drives = read([make_drive(1, blank=[5])], progress=lambda *step: told.append(step))
    assert (drives.skipped, len(drives.panoramas)) == (1, 39)
    assert told[-1] == ("drive 1", 40, 40)


def test_odometry_is_of_one_drive(garden):
    poses = [Pose2D(float(x), 0.0, 0.1) for x in range(8)]
    pictures = [garden.panorama(pose) for pose in garden.loop(8)]
    drive = MemoryRecording(pictures, range(8), garden.panorama_camera, odometry=poses)
    assert read([drive], "odometry").xy[:, 0] == pytest.approx(np.arange(8))
    with pytest.raises(RecordingError, match=r"the odometry of 2 recordings is in as many frames; give one"):
        read([drive, drive], "odometry")
    with pytest.raises(RecordingError, match=r"no reference positions"):
        read([drive])
