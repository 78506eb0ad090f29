import csv
import io
import math
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.data import Pose2D
from andante.errors import RecordingError
from andante.recordings.table import COLUMNS, frame_infos, own_columns, parse_table, read_text

HEADER = ",".join(COLUMNS)


def infos(text):
    table = parse_table(text, "frames.csv")
    return frame_infos(table, own_columns(table))


def test_all_columns_and_blank_cells():
    first, second = infos(f"{HEADER}\n0.5,a.jpg,1,2,3,4,5,6,7\n1.5,b.jpg,1,2,,,,,\n")
    assert (first.odometry, first.reference, first.place) == (Pose2D(1, 2, 3), Pose2D(4, 5, 6), 7)
    assert (second.odometry, second.reference, second.place) == (Pose2D(1, 2, None), None, None)
    assert [first.index, second.index, second.image, second.timestamp_s] == [0, 1, "b.jpg", 1.5]


def test_columns_may_come_in_any_order():
    (info,) = infos("image,y_m,x_m,timestamp_s\na.jpg,2,1,0\n")
    assert info.reference == Pose2D(1, 2)


@pytest.mark.parametrize(
    "text",
    [
        "timestamp_s,image\r\n0,a.jpg\r\n1,b.jpg\r\n",
        "timestamp_s,image\r0,a.jpg\r1,b.jpg",
        '"timestamp_s","image"\n"0","a.jpg"\n"1","b.jpg"',
        " timestamp_s , image \n 0 , a.jpg \n\n 1 , b.jpg \n\n",
    ],
    ids=["crlf", "cr", "quoted", "spaces and blank lines"],
)
def test_habits_of_spreadsheets_are_tolerated(text):
    assert [(info.timestamp_s, info.image) for info in infos(text)] == [(0, "a.jpg"), (1, "b.jpg")]


def test_byte_order_mark_is_dropped(tmp_path):
    (tmp_path / "t.csv").write_bytes("\ufefftimestamp_s,image\n".encode())
    assert read_text(tmp_path / "t.csv") == "timestamp_s,image\n"


def test_files_that_are_no_text(tmp_path):
    with pytest.raises(RecordingError, match=r"t\.csv does not exist"):
        read_text(tmp_path / "t.csv")
    with pytest.raises(RecordingError, match="cannot be read: Is a directory"):
        read_text(tmp_path)
    (tmp_path / "t.csv").write_bytes(b"image\xff\xfe")
    with pytest.raises(RecordingError, match=r"is not UTF-8 text \(byte 5\); save it as UTF-8"):
        read_text(tmp_path / "t.csv")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"frames\.csv: no rows"),
        ("timestamp_s,image\n", "no rows; a recording needs a header line and at least one frame"),
        ("timestamp_s,picture\n0,a", r"unknown column 'picture'; allowed are timestamp_s, image, odom_x_m, .*place"),
        ("timestamp_s,place\n0,1", "no column 'image' for image; found timestamp_s, place"),
        ("image,image\na,b", "column 'image' appears twice in the header"),
        ("timestamp_s,image\n0,a,1", r"frames\.csv line 2: 3 cells, the header has 2; leave a cell blank"),
        ('timestamp_s,image\n0,"a', r"line 2: not a table \(unexpected end of data\); check its quotes"),
        ("timestamp_s,image\n,a", "line 2, column timestamp_s: is blank; every frame needs a time"),
        ("timestamp_s,image\n0,", "line 2, column image: is blank; every frame needs an image"),
        ("timestamp_s,image\n0,a\nnoon,b", r"line 3, column timestamp_s: 'noon' is not a finite number"),
        ("timestamp_s,image\n1_0,a", "'1_0' is not a finite number"),
        ("timestamp_s,image,x_m,y_m\n0,a,1e300,1", "line 2, column x_m: '1e300' is beyond 1e\\+09; give metres and"),
        ("timestamp_s,image,x_m,y_m\n0,a,nan,1", "line 2, column x_m: 'nan' is not a finite number"),
        ("timestamp_s,image,x_m,y_m\n0,a,1,-inf", "column y_m: '-inf' is not a finite number"),
        ("timestamp_s,image,x_m,y_m\n0,a,1,1e999", "column y_m: '1e999' is not a finite number"),
        ("timestamp_s,image,x_m,y_m\n0,a,1,", "column y_m: is blank beside other values of this pose"),
        ("timestamp_s,image,x_m\n0,a,1", "column y_m: is blank beside"),
        ("timestamp_s,image,heading_rad\n0,a,1", "column x_m: is blank beside"),
        ("timestamp_s,image,odom_x_m,odom_y_m\n0,a,,3", "column odom_x_m: is blank beside"),
        ("timestamp_s,image,place\n0,a,1.5", "column place: '1.5' is not a whole number"),
        ("timestamp_s,image,place\n0,a," + "9" * 19, "is not a whole number of at most 18 digits"),
        ("timestamp_s,image\n0,a\n\n2,b\n2,c", r"times must increase, line 5 has 2\.0 s after 2\.0 s in line 4; sort"),
        ("timestamp_s,image\n3,a\n2,b", r"line 3 has 2\.0 s after 3\.0 s in line 2"),
        ("timestamp_s,image\n0,/etc/a.jpg", "column image: '/etc/a.jpg' leads out of the recording"),
        ("timestamp_s,image\n0,images/../../a.jpg", "leads out of the recording; paths are relative"),
        ("timestamp_s,image\n0,images\\..\\a.jpg", "leads out of the recording"),
        ("timestamp_s,image\n0,C:\\a.jpg", "leads out of the recording"),
        ("timestamp_s,image\n0,a\0b", "holds control characters"),
    ],
)
def test_faults_name_line_column_and_value(text, message):
    with pytest.raises(RecordingError, match=message) as raised:
        infos(text)
    assert "\n" not in str(raised.value)


finite = st.floats(-1e9, 1e9)
poses = st.none() | st.builds(Pose2D, finite, finite, st.none() | finite)
names = st.text(st.characters(exclude_categories=["C"]), min_size=1).filter(
    lambda name: name == name.strip() and ".." not in name and not name.startswith(("/", "\\")) and name[1:2] != ":"
)


@given(
    st.lists(st.tuples(names, poses, poses, st.none() | st.integers(-(10**17), 10**17)), min_size=1),
    st.floats(-1e9, 1e9),
)
def test_written_tables_read_back_exactly(rows, start):
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(COLUMNS)

    def cells(pose):
        return ["", "", ""] if pose is None else [pose.x_m, pose.y_m, pose.heading_rad]

    times = [start + 0.25 * index for index in range(len(rows))]
    for time, (name, odometry, reference, place) in zip(times, rows, strict=True):
        writer.writerow([time, name, *cells(odometry), *cells(reference), place])
    read = infos(text.getvalue())
    assert [(info.image, info.odometry, info.reference, info.place) for info in read] == rows
    assert [info.timestamp_s for info in read] == times


@given(
    st.text(max_size=50)
    | st.text(alphabet='0123456789.,-einfa"\n\r\t ', max_size=50).map(lambda text: f"{HEADER}\n{text}")
)
def test_any_text_gives_frames_or_a_recording_error(text):
    with suppress(RecordingError):
        assert all(math.isfinite(info.timestamp_s) for info in infos(text))
