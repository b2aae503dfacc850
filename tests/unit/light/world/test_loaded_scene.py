"""Which scene shows what: an update that is interrupted is made again, whole, whatever is asked for next."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from magicsim.config.models import load_preset
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.elastomer import build_elastomer
from magicsim.light.world.finish import Finish
from magicsim.light.world.loaded_scene import Worlds
from magicsim.scenes.timeline import View

PLACES = [np.full((3, 3), float(number)) for number in range(2)]


class Shown:
    """Takes an update part by part, and stops before one of them."""

    def __init__(self) -> None:
        self.parts: dict[str, Any] = {}
        self.stops_before = 99

    def update(self, **changes: Any) -> None:
        for number, (name, value) in enumerate(changes.items()):
            if number == self.stops_before:
                raise KeyboardInterrupt
            self.parts[name] = value


@pytest.mark.parametrize("stops_before", [0, 1, 2, 3])
@pytest.mark.parametrize("next_state", [0, 1])
def test_interrupted_update_leaves_no_part_of_it(stops_before: int, next_state: int):
    design = load_preset(ElastomerDesign, "design", "mini-magictac", ["footprint_mm=[8,8]"])
    elastomer = build_elastomer(design, facet_mm=4)
    shown = Shown()
    worlds = Worlds(elastomer, SimpleNamespace(), Finish(), lambda _: shown)  # type: ignore[arg-type, return-value]
    views = [View(body=each, infill=each, flashlight_x_mm=float(each[0, 0])) for each in PLACES]
    worlds.of(views[0], PLACES[0])
    shown.stops_before = stops_before
    with pytest.raises(KeyboardInterrupt):
        worlds.of(views[1], PLACES[1])
    shown.stops_before = 99
    worlds.of(views[next_state], PLACES[next_state])
    wanted = PLACES[next_state]
    assert all(shown.parts[name] is wanted for name in ("body", "infill", "object_vertices"))
    assert shown.parts.get("light_x_mm", 0.0) == wanted[0, 0]
