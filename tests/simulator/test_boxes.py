import numpy as np

from andante.simulator.boxes import ObjectBox, boxes_csv, object_boxes

NAMES = ("ground1", "tree1", "car1", "hills1")


def picture():
    return np.full((10, 20), -1, np.int32)


def test_a_box_holds_all_pixels_of_its_object_and_no_more():
    ids = picture()
    ids[2:5, 3:9] = 1
    ids[7, 12:14] = 2
    assert object_boxes(ids, NAMES, wraps=True) == [ObjectBox("tree1", 3, 2, 8, 4, 18)]
    assert ObjectBox("car1", 12, 7, 13, 7, 2) in object_boxes(ids, NAMES, wraps=True, min_pixels=2)


def test_an_object_across_the_seam_has_one_box_on_each_side():
    ids = picture()
    ids[2:6, :3] = 2
    ids[3:5, 16:] = 2
    assert object_boxes(ids, NAMES, wraps=True) == [
        ObjectBox("car1", 0, 2, 2, 5, 12, seam=True),
        ObjectBox("car1", 16, 3, 19, 4, 8, seam=True),
    ]
    assert object_boxes(ids, NAMES, wraps=False) == [ObjectBox("car1", 0, 2, 19, 5, 20)]


def test_the_widest_gap_is_what_an_object_leaves_free_not_a_hole_in_it():
    ids = picture()
    ids[2:6, :5] = 1
    ids[2:6, 2] = -1
    ids[2:6, 15:] = 1
    assert [(box.x_min, box.x_max) for box in object_boxes(ids, NAMES, wraps=True)] == [(0, 4), (15, 19)]


def test_what_goes_all_around_has_one_box_and_the_surroundings_none():
    ids = picture()
    ids[5:] = 1
    ids[8:] = 0
    ids[:2] = 3
    assert object_boxes(ids, NAMES, wraps=True) == [ObjectBox("tree1", 0, 5, 19, 7, 60)]


def test_the_table_has_one_row_a_box():
    text = boxes_csv([(4, ObjectBox("car1", 0, 2, 2, 5, 12, seam=True))])
    assert text == "frame,object,x_min,y_min,x_max,y_max,pixels,seam\n4,car1,0,2,2,5,12,1\n"
