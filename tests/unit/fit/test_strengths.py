import numpy as np
import pytest

from magicsim.fit.strengths import fit_strengths, lit_channels, lit_signal

BLOCKS = (4, 4)


def bases() -> list[dict[str, np.ndarray]]:
    """Two lights that fall off from either side, and a third one in the second state alone."""
    row, column = np.indices((32, 32)) / 32
    one = np.stack([np.exp(-2 * column), 0 * row, 0 * row], -1).astype(np.float32)
    other = np.stack([0 * row, np.exp(2 * column - 2), np.exp(-row)], -1).astype(np.float32)
    flash = np.stack([np.exp(-((row - 0.5) ** 2))] * 3, -1).astype(np.float32)
    return [{"left": one, "right": other}, {"left": one, "right": other, "flash": flash}]


TRUE = {
    ("left", 0): 0.3, ("right", 1): 0.2, ("right", 2): 0.5, ("flash", 0): 0.1, ("flash", 1): 0.2, ("flash", 2): 0.3,
}  # fmt: skip


@pytest.mark.parametrize("gamma", [1.0, 2.2])
@pytest.mark.parametrize("crosstalk", [0.0, 0.2])
def test_strengths_are_found_again(gamma: float, crosstalk: float):
    matrix = (1 - 1.5 * crosstalk) * np.eye(3) + crosstalk / 2
    states = bases()
    assert set(lit_channels(states)) == set(TRUE)
    signals = []
    for basis in states:
        light = np.zeros((32, 32, 3))
        for (name, channel), strength in TRUE.items():
            light[..., channel] += strength * basis[name][..., channel] if name in basis else 0
        signals.append(light @ matrix.T)
    found = fit_strengths(states, signals, matrix, blocks=BLOCKS, gamma=gamma)
    assert found == pytest.approx(TRUE, rel=1e-6)
    for basis, signal in zip(states, signals, strict=True):
        assert lit_signal(found, basis, matrix) == pytest.approx(signal, abs=1e-6)


def test_no_light_takes_light_away():
    states = bases()[:1]
    signals = [np.tile([0.2, 0.0, 0.1], (32, 32, 1))]
    assert min(fit_strengths(states, signals, np.eye(3), blocks=BLOCKS, gamma=1.0).values()) == 0
