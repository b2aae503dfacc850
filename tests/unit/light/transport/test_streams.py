"""No two things of a frame draw the same random numbers."""

from types import SimpleNamespace

from magicsim.light.transport import streams
from magicsim.light.world.names import ENVIRONMENT, FLASHLIGHT
from magicsim.light.world.shapes import lights
from magicsim.scenes.rig import MOST_LIGHTS


def test_every_stream_is_one_things_own_and_no_lights():
    own = {name: value for name, value in vars(streams).items() if name.isupper() and name != "SEEDS_PER_RENDER"}
    outer = 2  # flashlight and room
    lights = range(1, 1 + MOST_LIGHTS + outer)
    assert len(set(own.values())) == len(own)
    assert not set(own.values()) & set(lights)
    assert 0 < min(own.values()) <= max(own.values()) < streams.SEEDS_PER_RENDER


def scene_with(*emitters: str) -> SimpleNamespace:
    """A scene with lights of these names, the room's among them."""
    shapes = [
        SimpleNamespace(id=lambda name=name: name, is_emitter=lambda: True) for name in emitters if name != ENVIRONMENT
    ]
    return SimpleNamespace(shapes=lambda: shapes, environment=lambda: ENVIRONMENT if ENVIRONMENT in emitters else None)


def test_no_other_light_draws_otherwise_where_the_flashlight_stands_in_the_scene_of_the_block():
    """Near frames have it in a scene of its own, touched ones in the block's: their noise must not tell."""
    others = lights(scene_with("strip_x", ENVIRONMENT, "strip_a"))
    assert lights(scene_with(FLASHLIGHT, "strip_x", "strip_a", ENVIRONMENT)) == [*others, FLASHLIGHT]
