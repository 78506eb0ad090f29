import threading

import pytest

from andante.errors import InputError, LearningError
from andante.landmarks.teaching import Relation

SHED = Relation(0.2, 1.4, 1.6, 1.8)


def test_from_nothing_to_saved(make_desk, searched):
    made = make_desk()
    desk = made.desk
    assert desk.state()["phase"] == "choose"
    assert desk.result is None
    state = searched(desk)
    assert (state["phase"], state["problem"], state["progress"]) == ("draw", None, {"done": 40, "total": 40})
    anchor = state["anchor"]
    assert len(anchor["frames"]) == 40
    assert len(anchor["previews"]) == 12
    assert {anchor["previews"][0], anchor["previews"][-1]} == {0, 39}

    desk.draw(" shed ", SHED)
    desk.draw("roof", Relation(0.2, 2.0, 1.6, 0.5))
    desk.remove("roof")
    (taught,) = desk.state()["landmarks"]
    assert (taught["name"], taught["frames"], len(taught["sheet"])) == ("shed", 40, 24)

    desk.finish({"shed": [3, 4]})
    assert desk.state()["phase"] == "saved"
    assert desk.state()["saved"]["folder"] == "monday.landmarks"
    ((lesson,),) = made.saved
    assert sorted(lesson.boxes) == [at for at in range(40) if at not in (3, 4)]
    (lessons, saved) = desk.result
    assert [one.name for one in lessons] == ["shed"]
    assert saved.next_command == "andante map monday"


def test_landmarks_survive_another_anchor(make_desk, searched):
    desk = make_desk().desk
    searched(desk)
    desk.draw("shed", SHED)
    state = searched(desk, "car")
    assert state["phase"] == "choose"
    assert state["problem"].startswith("no car was found in any frame")
    assert [one["name"] for one in state["landmarks"]] == ["shed"]
    with pytest.raises(InputError, match="no anchor to draw beside"):
        desk.draw("tree", SHED)
    assert searched(desk)["problem"] is None
    desk.draw("tree", SHED)


def test_anchor_in_three_frames_only(make_desk, searched):
    state = searched(make_desk(found=range(3)).desk)
    assert state["phase"] == "choose"
    assert state["problem"] == (
        "the bicycle was found in 3 frames only, at least 10 are needed; drive nearer to it, more slowly, or choose "
        "another kind of anchor"
    )


def test_faults(make_desk, searched):
    desk = make_desk().desk
    with pytest.raises(InputError, match="no detector knows an anchor 'unicorn'; choose one of: bicycle, car, cow"):
        desk.search("unicorn")
    with pytest.raises(InputError, match="no landmark is drawn yet"):
        desk.finish({})
    searched(desk)
    desk.draw("shed", SHED)
    with pytest.raises(InputError, match="there is a landmark 'Shed' already"):
        desk.draw("Shed", SHED)
    with pytest.raises(InputError, match="there is no landmark 'tree'"):
        desk.remove("tree")
    with pytest.raises(InputError, match="there is no landmark 'tree'"):
        desk.finish({"tree": [1]})
    with pytest.raises(LearningError, match="'shed' would be left with 5 frames, at least 10"):
        desk.finish({"shed": range(35)})
    assert desk.state()["phase"] == "draw"
    desk.finish({})
    with pytest.raises(InputError, match="everything is saved already"):
        desk.finish({})
    with pytest.raises(InputError, match="saved already"):
        desk.search("bicycle")


def test_a_search_that_takes_long_can_be_stopped(make_desk):
    made = make_desk()
    begun, ended, go_on = threading.Event(), threading.Event(), threading.Event()

    def slowly(recording, name, progress, *, chosen):
        try:
            progress(1, 40)
            begun.set()
            go_on.wait(10)
            progress(2, 40)
        finally:
            ended.set()

    made.finder.find = slowly
    made.desk.search("bicycle")
    assert begun.wait(10)
    assert made.desk.state()["progress"] == {"done": 1, "total": 40}
    with pytest.raises(InputError, match="a search is running"):
        made.desk.search("bicycle")
    made.desk.stop_search()
    go_on.set()
    assert ended.wait(10)
    for _ in range(500):
        if made.desk.state()["phase"] == "choose":
            break
        threading.Event().wait(0.01)
    assert (made.desk.state()["phase"], made.desk.state()["problem"]) == ("choose", None)


def test_a_save_that_fails_can_be_tried_again(make_desk, searched):
    made = make_desk()
    searched(made.desk)
    made.desk.draw("shed", SHED)

    def full(_):
        raise InputError("the disk is full")

    good, made.desk._save = made.desk._save, full
    with pytest.raises(InputError, match="the disk is full"):
        made.desk.finish({})
    assert made.desk.state()["phase"] == "draw"
    made.desk._save = good
    made.desk.finish({})
