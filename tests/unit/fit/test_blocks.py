import numpy as np
import pytest

from magicsim.errors import ConfigError
from magicsim.fit.strengths import block_contrast, block_means, check_blocks


def grid(shift: float = 0.0) -> np.ndarray:
    """Lines across a ramp, shape (64, 48, 3)."""
    row, column = np.indices((64, 48), dtype=float)
    return (60 + 0.2 * row + 20 * np.sin(2 * np.pi * (column + shift) / 6))[..., None] * [1.0, 0.8, 0.6]


def test_means_and_contrast_do_not_know_where_the_grid_lines_lie():
    assert block_means(grid(), (4, 4)) == pytest.approx(block_means(grid(2.3), (4, 4)), abs=1e-9)
    assert block_contrast(grid(), grid(), (4, 4)) == pytest.approx(
        block_contrast(grid(2.3), grid(2.3), (4, 4)), abs=1e-9
    )


def test_contrast_is_the_standard_deviation_in_a_block():
    image = grid()
    assert block_contrast(image, image, (1, 1))[0, 0] == pytest.approx(image.std((0, 1)))


def test_noise_of_two_images_does_not_raise_their_contrast():
    random = np.random.default_rng(0)
    noisy = [grid() + random.normal(0, 8, (64, 48, 3)) for _ in range(2)]
    clean = block_contrast(grid(), grid(), (2, 2))
    alone = block_contrast(noisy[0], noisy[0], (2, 2))
    assert block_contrast(*noisy, (2, 2)) == pytest.approx(clean, rel=0.15)
    assert (alone > 1.1 * clean).all()


@pytest.mark.parametrize("blocks", [(0, 3), (17, 2), (2, 13)])
def test_blocks_that_are_too_small_are_refused(blocks: tuple[int, int]):
    with pytest.raises(ConfigError, match="must be 1x1 to 16x12 for images of 64 rows and 48 columns"):
        check_blocks(blocks, rows=64, columns=48)
