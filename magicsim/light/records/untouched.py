"""The untouched sensor, rendered and recorded, kept so that the episodes of one sensor do it once."""

import hashlib
import json
from collections import OrderedDict
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.markers import PictureMarkers
from magicsim.light.transport.light_field import LightField
from magicsim.scenes.rig import DARK, Rig
from magicsim.scenes.scene import RenderSettings

if TYPE_CHECKING:
    from magicsim.light.records.recorded_paths import RecordedPaths
    from magicsim.light.records.untouched_store import UntouchedStore
    from magicsim.light.transport.recorded_light import RecordedLight

KEPT = 2
"""Sensors that are kept at most."""
RECORDED_PARTS = 4
"""The careful state records the way out of every so manieth particle: few of them meet the object."""
OPTICAL_CAMERA = frozenset(
    {"columns", "rows", "distance_mm", "field_mm", "principal_offset_px", "distortion", "vignetting"}
)
"""What the radiance depends on; the rest of the camera comes after it."""

OPTICAL_SETTINGS = {"estimator", "forward_collisions", "anchor_samples", "anchor_particles", "anchor_seed"}
"""What it depends on of the rendering; a frame's own samples, particles and seed are none of it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Untouched:
    """One sensor, untouched, with some samples, particles and seed.

    Frames refer to two of them. The careful one has many samples and a seed of its own, the same for every episode: an
    untouched sensor always looks the same. The cheap one has the samples, particles and random numbers of a frame.
    """

    fields: dict[str, LightField]
    """What each light brings."""
    particles: dict[str, int]
    """Of each light."""
    paths: "RecordedPaths"
    """Of the camera."""
    light: "RecordedLight"
    """Of the strips, that leaves the block."""
    held_mm3: npt.NDArray[np.float64]
    """Volume of the body in each voxel, shape (voxels, 1); 1 where the body is clear."""
    image: npt.NDArray[np.float32]
    """Linear radiance of the ideal image, shape (rows, columns, 3)."""


class UntouchedStates:
    """The last few sensors of this process, and those on disk; their content depends on their key alone."""

    def __init__(self, store: "UntouchedStore | None" = None) -> None:
        """Holds nothing.

        Args:
            store: Where careful states are kept on disk, if they are.
        """
        self._states: OrderedDict[str, Untouched] = OrderedDict()
        self._store = store

    def get(self, key: str, *, on_disk: bool = False) -> Untouched | None:
        """The state of a key, if it is kept; also on disk where that is asked for."""
        if key not in self._states and on_disk and self._store is not None:
            stored = self._store.load(key)
            if stored is not None:
                self.keep(key, stored)
        if key in self._states:
            self._states.move_to_end(key)
        return self._states.get(key)

    def keep(self, key: str, state: Untouched, *, on_disk: bool = False) -> None:
        """Keeps a state, and lets the one go that was not asked for the longest."""
        if on_disk and self._store is not None:
            self._store.save(key, state)
        self._states[key] = state
        while len(self._states) > 2 * KEPT:
            self._states.popitem(last=False)


@cache
def shared_states() -> UntouchedStates:
    """Those of this process: episodes of one sensor render it once."""
    from magicsim.light.records.untouched_store import default_store

    return UntouchedStates(default_store())


def _digest(rig: Rig) -> str | None:
    """Of the room's image: a file may be replaced by another of that name."""
    if rig.room in (None, DARK):
        return None
    from magicsim.scenes.room import room_file

    return hashlib.sha256(room_file(rig.room).read_bytes()).hexdigest()


def untouched_key(design: ElastomerDesign, rig: Rig, settings: RenderSettings) -> str:
    """Everything that the untouched state depends on."""
    data = [
        design.model_dump(mode="json"),
        rig.model_dump(mode="json", include={"strips", "leds", "ring", "lens", "ambient", "room"}),
        _digest(rig),
        design.markers.digest() if isinstance(design.markers, PictureMarkers) else None,
        rig.camera.model_dump(mode="json", include=set(OPTICAL_CAMERA)),
        settings.model_dump(mode="json", include=OPTICAL_SETTINGS),
    ]
    return json.dumps(data, sort_keys=True)
