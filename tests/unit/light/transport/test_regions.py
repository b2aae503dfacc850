"""Boxes tell which triangles reach where, for points and for paths."""

import numpy as np
import pytest

from magicsim.light.backend import VARIANT, columns, dr, mi
from magicsim.light.transport.path_record import WORD, PathRecord, Regions

LOW, HIGH = np.array([-2.0, -1.0, 0.0]), np.array([2.0, 1.0, 3.0])
FACES = np.array([[0, 1, 2], [3, 4, 5]], np.int32)
VERTICES = np.array([[-1.9, -0.9, 0.1], [-1.8, -0.9, 0.1], [-1.9, -0.8, 0.1], [-1.9, 0.5, 2.5], [1.9, 0.5, 2.5],
                     [1.9, 0.5, 2.4]])  # fmt: skip


@pytest.fixture
def regions():
    return Regions.of(LOW, HIGH, 100)


def test_boxes_fill_the_block(regions):
    assert regions.counts == (4, 2, 3)
    assert regions.words == 1


def test_boxes_grow_until_memory_holds_them():
    coarse = Regions.of(LOW, HIGH, 2**31 // 4)
    assert np.prod(coarse.counts) <= 4
    assert coarse.edge_mm > 1


def test_a_small_triangle_reaches_its_box_and_a_long_one_all_along_it(regions):
    of_small, of_long = (set(np.flatnonzero(regions.reached(VERTICES, face[None]))) for face in FACES)
    assert of_small == {0}
    assert of_long == {16 + 4 + column for column in range(4)}  # third layer, second row


def test_bits_are_those_of_the_chosen_boxes(regions):
    chosen = np.zeros(24, bool)
    chosen[[0, 5, 23]] = True
    (word,) = regions.bits(chosen)
    assert [bit for bit in range(WORD) if word >> bit & 1] == [0, 5, 23]


@pytest.mark.skipif(VARIANT == "scalar_rgb", reason="needs LLVM or CUDA")
def test_a_path_finds_the_box_that_a_mesh_reaches(regions):
    points = np.random.default_rng(1).uniform(LOW, HIGH, (200, 3))
    found = np.array(regions.index(mi.Point3f(*points.T.astype(np.float32))))
    small = np.repeat(points, 3, axis=0) + np.tile([[0, 0, 0], [1e-6, 0, 0], [0, 1e-6, 0]], (200, 1))
    faces = np.arange(600, dtype=np.int32).reshape(-1, 1, 3)
    assert all(regions.reached(small, face)[box] for box, face in zip(found, faces, strict=True))


@pytest.mark.parametrize("lanes", [64, 75])
def test_what_each_lane_met_is_kept_for_that_lane(lanes):
    boxes, random = Regions.of(LOW, 4 * HIGH, 100), np.random.default_rng(3)
    assert boxes.words > 2
    record = PathRecord.empty(1, 1, lanes=lanes, regions=boxes)
    met = np.zeros((lanes, int(np.prod(boxes.counts))), bool)
    for _ in range(3):
        points = random.uniform(LOW, 4 * HIGH, (lanes, 3))
        met[np.arange(lanes), np.array(boxes.index(mi.Point3f(*columns(points))))] = True
        record.mark(dr.arange(mi.UInt32, lanes), mi.Point3f(*columns(points)), mi.Bool(True))
    kept = np.array(record.met)[: boxes.words * lanes].reshape(boxes.words, lanes)
    np.testing.assert_array_equal(kept, np.stack([boxes.bits(each) for each in met], 1))
