"""Small sensors that render in seconds."""

from collections.abc import Callable, Iterator

import pytest

from magicsim.light.variant import SCALAR_VARIANT, activate_variant
from magicsim.scenes.scene import SceneConfig, load_scene

SMALL = (
    "rig=digit-rgb",
    "design.footprint_mm=[12,15]",
    "design.lattice.cells_across=0",
    "rig.camera.field_mm=10",
    "rig.camera.columns=48",
    "rig.camera.rows=64",
    "render.samples=16",
    "render.particles=60000",
    "render.anchor_samples=0",
)


@pytest.fixture(scope="module")
def untouched_once(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Tests of one untouched sensor compute it once, as commands do, and keep it in a folder of this run."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MAGICSIM_CACHE", str(tmp_path_factory.getbasetemp() / "untouched"))
        yield


@pytest.fixture(scope="session")
def small_scene() -> Callable[..., SceneConfig]:
    """A scene preset at 48 x 64 pixels on a block of 12 x 15 mm, unanchored, with further overrides."""
    if activate_variant() == SCALAR_VARIANT:
        pytest.skip("the fluence estimator needs LLVM or CUDA")

    def load(name: str, *overrides: str, seed: int | None = None) -> SceneConfig:
        return load_scene(name, [*SMALL, *overrides], seed=seed)

    return load


@pytest.fixture(scope="session")
def whole_block(small_scene: Callable[..., SceneConfig]) -> Callable[..., SceneConfig]:
    """The same on the whole block of 24 x 32 mm, where places on it are what a test is about."""

    def load(name: str, *overrides: str, seed: int | None = None) -> SceneConfig:
        return small_scene(name, "design.footprint_mm=[24,32]", "rig.camera.field_mm=22.8", *overrides, seed=seed)

    return load
