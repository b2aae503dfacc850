"""The untouched sensor, rendered and recorded, and everything that it depends on."""

import hashlib
import json
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from magicsim.config.named_files import file_hashes
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

OPTICAL_SETTINGS = {
    "estimator", "forward_collisions", "facet_mm", "anchor_samples", "anchor_particles", "anchor_seed",
}  # fmt: skip
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
        settings.model_dump(mode="json", include=OPTICAL_SETTINGS),
    ]
    if isinstance(design.face, HeightMap):
        data.append(file_hashes(design.face.model_dump(mode="json")))
    if rig.near_mm is not None:
        data.append({"room_distance_mm": rig.near_mm})
    return json.dumps(data, sort_keys=True)
