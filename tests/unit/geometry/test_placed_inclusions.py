"""Bubbles and flakes of a print: as many and as large as asked for, inside their cells, moving with them."""

import numpy as np
import pytest

from magicsim.errors import ConfigError
from magicsim.geometry.design import load_design
from magicsim.geometry.elastomer import build_elastomer

SMALL = ("footprint_mm=[12, 14]",)
BOTH = ("inclusions.bubbles_per_mm3=1", "inclusions.flakes_per_mm3=0.5")


def built(*settings: str):
    return build_elastomer(load_design("mini-magictac", [*SMALL, *settings]))


def test_the_default_print_is_clean():
    assert built().inclusions is None


def test_density_and_radii_are_as_asked_for():
    found = built(*BOTH, "inclusions.bubble_radius_mm=[0.03,0.06]")
    drawn, volume = found.inclusions, found.grid.infill_volume_mm3
    for is_bubble, density in ((True, 1.0), (False, 0.5)):
        count = np.count_nonzero(drawn.is_bubble == is_bubble)
        assert count == pytest.approx(density * volume, abs=4 * np.sqrt(density * volume))
    bubbles = drawn.radii_mm[drawn.is_bubble]
    assert 0.03 <= bubbles.min() <= bubbles.max() <= 0.06
    assert bubbles.mean() == pytest.approx(0.045, rel=0.05)
    np.testing.assert_allclose(np.linalg.norm(drawn.normals, axis=1), 1)


def test_each_lies_in_its_cell_and_clear_of_the_others():
    found = built("inclusions.bubbles_per_mm3=6", "inclusions.bubble_radius_mm=[0.05,0.2]")
    placed = found.inclusions.placed(found.infill.vertices)
    cells = found.infill.vertices.reshape(found.grid.cell_count, -1, 3)[placed.cell]
    room = np.minimum(placed.centres_mm - cells.min(1), cells.max(1) - placed.centres_mm).min(1)
    assert (room > placed.radii_mm).all()
    for cell in np.unique(placed.cell):
        mine = np.flatnonzero(placed.cell == cell)
        away = np.linalg.norm(placed.centres_mm[mine, None] - placed.centres_mm[mine], axis=2)
        np.fill_diagonal(away, np.inf)
        assert (away > placed.radii_mm[mine, None] + placed.radii_mm[mine]).all()


def test_they_move_with_the_material():
    found = built(*BOTH)
    stretch = np.array([[1.1, 0.2, 0.0], [0.0, 0.8, 0.0], [0.0, 0.1, 0.9]])
    rest, moved = (found.inclusions.placed(v) for v in (found.infill.vertices, found.infill.vertices @ stretch.T + 2))
    np.testing.assert_allclose(moved.centres_mm, rest.centres_mm @ stretch.T + 2, atol=1e-9)
    narrowest = np.linalg.svd(stretch, compute_uv=False).min()
    np.testing.assert_allclose(moved.radii_mm, narrowest * rest.radii_mm)
    # A platelet stays across what crossed it: normals move as those of surfaces in the material.
    across = np.cross(rest.normals, [0.3, 0.5, 0.7])
    np.testing.assert_allclose((moved.normals * (across @ stretch.T)).sum(1), 0, atol=1e-9)


def test_each_seed_is_a_print_of_its_own():
    one, same, other = (built(*BOTH, f"inclusions.seed={seed}").inclusions for seed in (1, 1, 2))
    np.testing.assert_array_equal(one.places, same.places)
    assert len(one.places) != len(other.places) or not np.array_equal(one.places, other.places)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (("inclusions.bubbles_per_mm3=-1",), r"inclusions\.bubbles_per_mm3"),
        (("inclusions.bubble_radius_mm=[0.1,0.05]",), "the first must be at most the second"),
        ((*BOTH, "inclusions.bubble_radius_mm=[0.1,0.4]"), r"must be at most 0\.35 cell_mm"),
        ((*BOTH, "cell_mm=0"), "bubbles and flakes lie in cells"),
        (("roughness.skin=0.9",), r"roughness\.skin"),
        (
            ("roughness.skin=0.1", 'coat={kind="half_mirror",reflectance=0.3,transmittance=0.5}'),
            "not allowed with coat",
        ),
    ],
)
def test_what_cannot_be_is_one_line(settings, message):
    with pytest.raises(ConfigError, match=message) as found:
        load_design("mini-magictac", [*SMALL, *settings])
    assert "\n" not in str(found.value)
