"""The carefully rendered untouched sensor, kept so that the episodes of one sensor render it once."""

import json
from collections import OrderedDict
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from magicsim.geometry.design import ElastomerDesign
from magicsim.scenes.anchor import Anchor
from magicsim.scenes.light_field import LightField
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import RenderSettings

if TYPE_CHECKING:
    from magicsim.scenes.recorded_light import RecordedLight
    from magicsim.scenes.recorded_paths import RecordedPaths

KEPT = 4
"""Sensors that are kept at most."""
RECORDED_PER_PARTICLE = 4
"""Light particles that are recorded for each one that a frame would trace: few of them meet the object."""
OPTICAL_CAMERA = frozenset(
    {"columns", "rows", "distance_mm", "field_mm", "principal_offset_px", "distortion", "vignetting"}
)
"""What the radiance depends on; the rest of the camera comes after it."""

OPTICAL_SETTINGS = {"estimator", "forward_collisions", "anchor_samples", "anchor_particles", "anchor_seed"}
"""What it depends on of the rendering; a frame's own samples, particles and seed are none of it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class UntouchedState:
    """One sensor, untouched, rendered with the samples, particles and seed of its anchor."""

    fields: dict[str, LightField]
    """What each light brings."""
    image: npt.NDArray[np.float32]
    """Linear radiance, shape (rows, columns, 3)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Recorded:
    """One sensor, untouched: what its camera paths and its light pass before they leave the block."""

    paths: "RecordedPaths"
    light: "RecordedLight"


class UntouchedStates:
    """The last few sensors of this process; their content depends on their key alone."""

    def __init__(self) -> None:
        """Holds nothing."""
        self._states: OrderedDict[str, UntouchedState] = OrderedDict()
        self._anchor: tuple[str, Anchor] | None = None
        self._recorded: tuple[str, Recorded] | None = None

    def get(self, key: str) -> UntouchedState | None:
        """The state of a key, if it is kept."""
        if key in self._states:
            self._states.move_to_end(key)
        return self._states.get(key)

    def keep(self, key: str, state: UntouchedState) -> None:
        """Keeps a state, and lets the one go that was not asked for the longest."""
        self._states[key] = state
        while len(self._states) > KEPT:
            self._states.popitem(last=False)

    def anchor(self, key: str) -> Anchor | None:
        """What the frames of a sensor and a seed refer to, if that was kept last."""
        return self._anchor[1] if self._anchor is not None and self._anchor[0] == key else None

    def keep_anchor(self, key: str, anchor: Anchor) -> None:
        """Keeps what the frames of one sensor and one seed refer to."""
        self._anchor = (key, anchor)

    def recorded(self, key: str) -> Recorded | None:
        """What was recorded of a sensor, if that was kept last: it is much."""
        return self._recorded[1] if self._recorded is not None and self._recorded[0] == key else None

    def keep_recorded(self, key: str, recorded: Recorded) -> None:
        """Keeps what was recorded of one sensor."""
        self._recorded = (key, recorded)


@cache
def shared_states() -> UntouchedStates:
    """Those of this process: episodes of one sensor render it once."""
    return UntouchedStates()


def untouched_key(design: ElastomerDesign, rig: Rig, settings: RenderSettings) -> str:
    """Everything that the untouched state depends on."""
    data = [
        design.model_dump(mode="json"),
        rig.model_dump(mode="json", include={"strips", "lens", "ambient"}),
        rig.camera.model_dump(mode="json", include=set(OPTICAL_CAMERA)),
        settings.model_dump(mode="json", include=OPTICAL_SETTINGS),
    ]
    return json.dumps(data, sort_keys=True)
