"""No two things of a frame draw the same random numbers."""

from magicsim.light.transport import streams
from magicsim.scenes.rig import MOST_LIGHTS


def test_every_stream_is_one_things_own_and_no_lights():
    own = {name: value for name, value in vars(streams).items() if name.isupper() and name != "SEEDS_PER_RENDER"}
    outer = 2  # flashlight and room
    lights = range(1, 1 + MOST_LIGHTS + outer)
    assert len(set(own.values())) == len(own)
    assert not set(own.values()) & set(lights)
    assert 0 < min(own.values()) <= max(own.values()) < streams.SEEDS_PER_RENDER
