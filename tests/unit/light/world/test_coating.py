"""Colours that move with the skin: the map from places in the scene to texels."""

import numpy as np

from magicsim.light.world.coated_face import affine_maps


def test_map_takes_corners_to_their_places_and_is_linear_between():
    random = np.random.default_rng(2)
    corners, places = random.normal(size=(50, 3, 3)), random.uniform(0, 100, (50, 3, 2))
    maps = affine_maps(corners, places)
    shares = random.dirichlet(np.ones(3), 50)
    point = np.einsum("tk,tki->ti", shares, corners)
    found = np.einsum("tij,tj->ti", maps[..., :3], point) + maps[..., 3]
    np.testing.assert_allclose(found, np.einsum("tk,tki->ti", shares, places), atol=1e-6)
