import numpy as np

from magicsim.deform.lattice.structure import box_lattice
from magicsim.live.controls import FULL_MM, MOVED, STILL, lattice_edges, segment_colors


def test_edges_join_neighbours_once_and_stand_up_on_the_rim_alone():
    lattice = box_lattice((np.arange(4.0), np.arange(3.0), np.arange(3.0)), shear_modulus_mpa=1, lame_mpa=1)
    edges = lattice_edges(lattice)
    ways = np.abs(lattice.nodes_mm[edges[:, 1]] - lattice.nodes_mm[edges[:, 0]])
    assert (ways.sum(1) == 1).all()
    assert len(np.unique(np.sort(edges, 1), axis=0)) == len(edges)
    assert (ways == [1, 0, 0]).all(1).sum() == 3 * 3 * 3
    assert (ways == [0, 1, 0]).all(1).sum() == 4 * 2 * 3
    assert (ways == [0, 0, 1]).all(1).sum() == 10 * 2  # ten of twelve columns stand on the rim


def test_colour_goes_from_still_to_moved():
    colors = segment_colors(np.array([0.0, FULL_MM, 5 * FULL_MM]), np.array([[0, 1], [1, 2]]))
    assert colors.shape == (2, 2, 3)
    assert (colors[0, 0] == STILL).all()
    assert (colors[0, 1] == MOVED).all()
    assert (colors[1, 1] == MOVED).all()
