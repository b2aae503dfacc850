"""The untouched sensor, rendered and recorded, everything that it depends on, and where it is kept.

On disk, what all frames of a sensor share is computed once on a machine, not once in a process. A file appears whole or
not at all, so several processes may write at once. Its name is the hash of everything that its content depends on, the
program and its libraries included; one that cannot be read is computed anew. The oldest ones go when all of them are
larger than allowed. `MAGICSIM_CACHE` names another folder, or is `off`.
"""

import hashlib
import json
import logging
import os
import platform
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from magicsim.config.named_files import file_hashes
from magicsim.config.presets import expanded
from magicsim.config.program import program_key
from magicsim.errors import MagicsimError
from magicsim.folder import result_file
from magicsim.folder.kept import KeptFiles, cache_folder
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.face_shape import HeightMap
from magicsim.geometry.markers import PictureMarkers
from magicsim.light.transport.light_field import LightField
from magicsim.scenes.rig import DARK, Rig
from magicsim.scenes.scene import RenderSettings

if TYPE_CHECKING:
    from magicsim.light.records.recorded_paths import RecordedPaths
    from magicsim.light.transport.recorded_light import RecordedLight


RECORDED_PARTS = 4
"""The anchor records the way out of every so manieth particle: few of them meet the object."""
OPTICAL_CAMERA = frozenset(
    {"columns", "rows", "distance_mm", "field_mm", "principal_offset_px", "distortion", "vignetting", "rendered_px"}
)
"""What the radiance depends on; the rest of the camera comes after it."""

OPTICAL_SETTINGS = frozenset(
    {"estimator", "forward_collisions", "facet_mm", "anchor_samples", "anchor_particles", "anchor_seed"}
)
"""What it depends on of the rendering; a frame's own samples, particles and seed are none of it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Untouched:
    """One sensor, untouched, with some samples, particles and seed.

    Frames refer to two of them. The anchor has many samples and a seed of its own, the same for every episode: an
    untouched sensor always looks the same. The control, as of a control variate, has the samples, particles and random
    numbers of a frame.
    """

    fields: dict[str, LightField]
    particles: dict[str, int]
    paths: "RecordedPaths"
    light: "RecordedLight"
    """Light of the strips that leaves the block."""
    room: "RecordedLight | None" = None
    """Light of the room that leaves it, if that was taken down: of all particles of the first beam."""
    held_mm3: npt.NDArray[np.float64]
    """Volume of the body in each voxel, shape (voxels, 1); 1 where the body is clear."""
    image: npt.NDArray[np.float32]
    """Linear radiance of the ideal image, shape (rows, columns, 3)."""


def _digest(rig: Rig) -> str | None:
    """Hash of the room's image: a file may be replaced by another of that name."""
    if rig.room in (None, DARK):
        return None
    from magicsim.scenes.room import room_file

    return hashlib.sha256(room_file(rig.room).read_bytes()).hexdigest()


def untouched_key(design: ElastomerDesign, rig: Rig, settings: RenderSettings) -> str:
    """Everything that the untouched state depends on."""
    data = [
        design.model_dump(mode="json", exclude={"limits"}),
        rig.model_dump(mode="json", include={"strips", "leds", "ring", "lens", "ambient", "room"}),
        _digest(rig),
        design.markers.digest() if isinstance(design.markers, PictureMarkers) else None,
        rig.camera.model_dump(mode="json", include=set(OPTICAL_CAMERA)),
        settings.model_dump(mode="json", include=set(OPTICAL_SETTINGS)),
    ]
    if isinstance(design.face, HeightMap):
        data.append(file_hashes(design.face.model_dump(mode="json")))
    if rig.near_mm is not None:
        data.append({"room_distance_mm": rig.near_mm})
    return json.dumps(data, sort_keys=True)


Made = TypeVar("Made")
KEPT = 2
"""Sensors that are kept at most."""
LOGGER = logging.getLogger(__name__)
VARIABLE, OFF = "MAGICSIM_CACHE", "off"


@dataclass(frozen=True, slots=True, kw_only=True)
class UntouchedStore(KeptFiles):
    """A folder of untouched sensors."""

    pattern: str = r"magicsim-untouched-[0-9a-f]{64}\.npz"
    most_bytes: int = 2_000_000_000
    """A sensor at 240 x 320 pixels takes about 150 MB, light through its face 50 MB more [bytes]."""

    def load(self, key: str, restored: Callable[[Any], Made]) -> Made | None:
        """What is made of the arrays of a key, None where they are not there or cannot be read."""
        path = self._path(key)
        try:
            with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
                state = restored(stored)
            self.touch(path)
        except (FileNotFoundError, NotADirectoryError):
            return None
        except MagicsimError:  # it is not the file
            raise
        except Exception as error:
            LOGGER.warning("%s cannot be read (%s) and is computed anew", path, type(error).__name__)
            return None
        return state

    def save(self, key: str, arrays: dict[str, Any]) -> bool:
        """Keeps the arrays of a key, and lets the oldest go; whether the folder can be written."""
        try:
            with result_file(self._path(key)) as partial, partial.open("wb") as file:
                np.savez(file, **arrays)
            self.shrink()
        except (OSError, MagicsimError) as error:
            LOGGER.warning("nothing is kept in %s: %s", self.folder, error)
            return False
        return True

    def _path(self, key: str) -> Path:
        return self.folder / f"magicsim-untouched-{hashlib.sha256((_program() + key).encode()).hexdigest()}.npz"


def default_store() -> UntouchedStore | None:
    """Store of this user, None where it is switched off or there is no home folder."""
    chosen = os.environ.get(VARIABLE, "")
    if chosen == OFF:
        return None
    folder = expanded(chosen) if chosen else cache_folder()
    return UntouchedStore(folder=folder) if folder is not None else None


@cache
def _program() -> str:
    """Everything beside a sensor's description that decides its bytes."""
    from magicsim.light.backend import VARIANT, dr

    width = dr.detail.llvm_version() if hasattr(dr.detail, "llvm_version") else ""
    return json.dumps([program_key(VARIANT), str(width), platform.machine(), platform.processor()])


def arrays_of(state: Untouched) -> dict[str, Any]:
    """A sensor as arrays."""
    paths, names = state.paths, list(state.fields)
    return {
        "about": np.array(json.dumps({"lights": names, "particles": state.particles, "samples": paths.samples,
                                      "recorded": state.light.particles, "shape": paths.response.shape})),
        **{f"fluence {name}": state.fields[name].fluence for name in names},
        **{f"body {name}": state.fields[name].body for name in names},
        **{f"irradiance {name}": state.fields[name].irradiance for name in names},
        "held": state.held_mm3, "image": state.image, "direct": paths.direct, "data": paths.response.data,
        "indices": paths.response.indices, "indptr": paths.response.indptr, "rays": np.array(paths.rays),
        "owner": paths.owner, "escapes": state.light.escapes(), "owners": state.light.owners,
    }  # fmt: skip


def untouched_of(stored: Any) -> Untouched:
    """The sensor of what `arrays_of` gave."""
    from magicsim.light.records.recorded_paths import RecordedPaths
    from magicsim.light.transport.recorded_light import RecordedLight

    about = json.loads(str(stored["about"]))
    fields = {
        name: LightField(
            fluence=stored[f"fluence {name}"], body=stored[f"body {name}"], irradiance=stored[f"irradiance {name}"]
        )
        for name in about["lights"]
    }
    response = sp.csr_matrix((stored["data"], stored["indices"], stored["indptr"]), tuple(about["shape"]))
    return Untouched(
        fields=fields,
        particles=about["particles"],
        paths=RecordedPaths.of(stored["direct"], response, stored["rays"], stored["owner"], about["samples"]),
        light=RecordedLight.of(stored["escapes"], stored["owners"], about["recorded"]),
        held_mm3=stored["held"],
        image=stored["image"],
    )  # fmt: skip


class UntouchedStates:
    """The last few sensors of this process, and those on disk; their content depends on their key alone."""

    def __init__(self, store: UntouchedStore | None = None) -> None:
        self._states: OrderedDict[str, Untouched] = OrderedDict()
        self._made: dict[str, OrderedDict[str, Any]] = {}
        self._store = store

    def get(self, key: str, *, on_disk: bool = False) -> Untouched | None:
        """The state of a key, if it is kept; also on disk where that is asked for."""
        if key not in self._states and on_disk and self._store is not None:
            stored = self._store.load(key, untouched_of)
            if stored is not None:
                self.keep(key, stored)
        if key in self._states:
            self._states.move_to_end(key)
        return self._states.get(key)

    def made(self, kind: str, key: str, make: Callable[[], Made]) -> Made:
        """What is made of the state of a key, kept for other episodes of its sensor: the last few of each kind."""
        kept = self._made.setdefault(kind, OrderedDict())
        if key not in kept:
            kept[key] = make()
            if len(kept) > KEPT:
                kept.popitem(last=False)
        kept.move_to_end(key)
        return cast("Made", kept[key])

    def arrays(self, key: str, make: Callable[[], dict[str, Any]]) -> dict[str, Any]:
        """Arrays that are on disk, or made and kept there."""
        stored = self._store.load(key, dict) if self._store is not None else None
        if stored is None:
            stored = make()
            if self._store is not None and not self._store.save(key, stored):
                self._store = None
        return stored

    def keep(self, key: str, state: Untouched, *, on_disk: bool = False) -> None:
        """Keeps a state, and lets the one go that was not asked for the longest."""
        if on_disk and self._store is not None and not self._store.save(key, arrays_of(state)):
            self._store = None
        self._states[key] = state
        while len(self._states) > 2 * KEPT:
            self._states.popitem(last=False)


@cache
def shared_states() -> UntouchedStates:
    """Untouched states of this process: episodes of one sensor render it once."""
    return UntouchedStates(default_store())
