"""Pictures on their way to learning: streams, temporary files, simulated headings."""

import threading

import numpy as np
import pytest

from andante.data import Edges
from andante.errors import ConfigError
from andante.sfa.map_store import ArrayMaps, SpooledMaps
from andante.sfa.pictures import TurnedMaps, edges_in_time, stored_pictures
from andante.sfa.threads import in_order


def test_maps_in_a_file_are_read_in_any_order():
    maps = np.random.default_rng(0).normal(size=(30, 2, 3, 4)).astype(np.float32)
    spooled = SpooledMaps((2, 3, 4), np.float32)
    spooled.append(maps[:11])
    spooled.append(maps[11:].transpose(0, 1, 3, 2).copy().transpose(0, 1, 3, 2))
    assert (len(spooled), spooled.shape) == (30, (2, 3, 4))
    for rows in (np.arange(30), np.array([4]), np.array([29, 3, 4, 5, 5, 0])):
        np.testing.assert_array_equal(spooled.take(rows), maps[rows])
        np.testing.assert_array_equal(ArrayMaps(maps).take(rows), maps[rows])
    with pytest.raises(EOFError, match="temporary file of 30 maps ends before map 30"):
        spooled.take(np.array([30]))


def test_one_array_stays_where_it_is_and_streams_are_stored():
    pictures = np.random.default_rng(0).integers(0, 255, (7, 4, 5)).astype(np.uint8)
    store, lengths = stored_pictures(pictures, np.float32)
    assert lengths == [7]
    assert np.shares_memory(store.take(np.arange(7)), pictures)
    store, lengths = stored_pictures([pictures[:3], lambda: iter([pictures[3:5], pictures[5:]])], np.float32)
    assert lengths == [3, 4]
    taken = store.take(np.arange(7))
    assert taken.dtype == np.uint8
    np.testing.assert_array_equal(taken[:, 0], pictures)


def test_edges_in_time_stay_inside_of_recordings():
    edges = edges_in_time([3, 1, 2])
    assert list(zip(edges.first, edges.second, strict=True)) == [(0, 1), (1, 2), (4, 5)]


def test_turned_panoramas_are_shifted_all_the_way_round():
    panoramas = np.random.default_rng(0).normal(size=(6, 1, 2, 40))
    turned = TurnedMaps(ArrayMaps(panoramas), 4)
    assert (len(turned), turned.shape) == (24, (1, 2, 40))
    copies = turned.take(np.arange(24)).reshape(6, 4, 2, 40)
    first = set()
    for panorama, own in zip(panoramas[:, 0], copies, strict=True):
        shifts = [[np.array_equal(np.roll(panorama, s, axis=-1), copy) for s in range(40)].index(True) for copy in own]
        assert set(np.diff(shifts)) <= {9, 10, 11}
        first.add(shifts[0])
    assert len(first) == 6
    np.testing.assert_array_equal(turned.take(np.array([17, 2])).ravel(), copies.reshape(24, -1)[[17, 2]].ravel())


def test_edges_of_turned_panoramas_run_around_and_along():
    turned = TurnedMaps(ArrayMaps(np.zeros((3, 1, 1, 9))), 3)
    edges = turned.edges(Edges(np.array([0, 1]), np.array([1, 2]), np.array([0.5, 2.0])))
    pairs = list(zip(edges.first, edges.second, edges.weight, strict=True))
    assert pairs[:2] == [(0, 3, 0.5), (4, 7, 2.0)]
    assert pairs[2:5] == [(0, 1, 1), (1, 2, 1), (2, 0, 1)]
    assert len(TurnedMaps(ArrayMaps(np.zeros((3, 1, 1, 9))), 2).edges(Edges.joined([]))) == 3
    with pytest.raises(ConfigError, match="turns=1: a picture is learnt in at least 2 headings"):
        TurnedMaps(ArrayMaps(np.zeros((3, 1, 1, 9))), 1)


def test_work_in_threads_comes_back_in_order_and_faults_come_out():
    started, lock = [], threading.Lock()

    def square(number):
        with lock:
            started.append(number)
        if number == 70:
            raise ValueError("seventy")
        return number**2

    assert list(in_order(square, range(50))) == [number**2 for number in range(50)]
    started.clear()
    with pytest.raises(ValueError, match="seventy"):
        list(in_order(square, range(1000)))
    assert len(started) < 100
