"""A distilled model of one sensor's touches: one file with its network, what it knows, and how far off it was.

The file is a ZIP archive of `network.onnx`, `model.json` (see `ModelFacts`) and `rest.npy`, the coarse untouched image
that the sensor had when the model was made.
"""

import hashlib
import io
import json
import zipfile
import zlib
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import cv2
import numpy as np
import numpy.typing as npt
from pydantic import Field

from magicsim.arrays import FloatImage
from magicsim.camera.film import blurred_px
from magicsim.config.documents import dotted
from magicsim.config.models import Config, validate
from magicsim.config.named_files import MODEL_SUFFIX
from magicsim.config.presets import preset_root
from magicsim.emulator.fields import Fields, filled
from magicsim.errors import ConfigError
from magicsim.geometry.design import ElastomerDesign
from magicsim.light.records.untouched import OPTICAL_CAMERA, untouched_key
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import RenderSettings

NETWORK, FACTS, REST = "network.onnx", "model.json", "rest.npy"
MODELS = "scenes/models"
"""Models that come with the program."""
COARSE_PX = 16
"""Pixels along a side that are one of the coarse untouched image."""
SAME_REST = 0.02
"""Root mean square difference of untouched images, in units of their mean, up to which they are of the same sensor."""
BESIDE = 0.5
"""By how much of the interval of what the model learned from a setting may lie beside it: few printed units span less
than all do, and the network sees the untouched image of each."""
SAME_BLUR_PX = 0.3
"""By how much pictures may be blurred otherwise than those that the model learned from [px]: at 1 px the touch of a
ball is as far off as at 0.7, at 3 px as far as if nothing touched."""
UNSEEN = {"schema_version", "mounting", "lattice", "limits"}
"""Settings of a design that no picture depends on but through displacements, which the network sees."""
SEED = ".seed"
"""How settings end that number random prints, each of which the network sees."""
UNSEEN_OF_MATERIALS = {
    "body": {"youngs_modulus_mpa", "poisson_ratio", "prony"}, "infill": {"shear_modulus_mpa", "bulk_modulus_mpa"},
}  # fmt: skip
LIGHTS = frozenset({"strips", "leds", "ring", "lens"})
ALL = "all"
"""What the row of all touches says that it is of."""
Number = Annotated[float, Field(ge=-1e9, le=1e9)]
Amount = Annotated[float, Field(ge=0, le=1e9)]
Count = Annotated[int, Field(ge=0, le=1_000_000_000)]
Interval = tuple[Number, Number]


class ErrorRow(Config):
    """How far off the model was in one kind of state that it had not seen, in linear grey levels of the rig's exposure.

    Errors are those of the change by a touch; the noise of the true frames is taken off.
    """

    states: str
    """Which."""
    touches: Count
    """How many of them."""
    change: Amount
    """What the touch changes, root mean square."""
    error: Amount
    """Root mean square error."""
    true_tier: Amount
    """Root mean square error of a frame of the true tier, with its own noise."""


class ModelFacts(Config):
    """What a model says of itself."""

    schema_version: Literal[1] = 1
    name: str
    """Design and rig that it was made for."""
    sensor: dict[str, str | Interval]
    """Settings of design, lights, lens and camera that a picture depends on: a text, or from which number to which."""
    rest_key: str
    """Digest of the sensor and room that the coarse untouched image is of."""
    rooms: list[str]
    """Rooms of the touches that it learned from."""
    kinds: list[str]
    """Kinds of objects."""
    depth_mm: Amount
    """Deepest touch."""
    specular: Number
    """Glossiest object."""
    spacing_mm: Amount
    """Finest texture; 0 where it learned from none."""
    blur_px: Amount = 0.7
    """Blur of its pictures, see `blurred_px`; by default that of the models that do not say it."""
    touches: Count
    """Touches that it learned from."""
    errors: list[ErrorRow] = Field(default_factory=list)
    versions: dict[str, str]
    """What made it, see `magicsim.config.program.versions`."""


@dataclass(frozen=True, kw_only=True)
class TouchModel:
    """A model that was read."""

    facts: ModelFacts
    network: bytes
    """ONNX."""
    rest: npt.NDArray[np.float32]
    """Coarse untouched image of the sensor without tolerances, in the rig's own room and in units of its mean."""

    @classmethod
    def read(cls, path: Path, field: str = "render.model") -> Self:
        """From a file that a field names.

        Raises:
            ConfigError: It cannot be read, or is not a model.
        """
        try:
            with zipfile.ZipFile(path) as archive:
                facts, network = json.loads(archive.read(FACTS)), archive.read(NETWORK)
                rest = np.load(io.BytesIO(archive.read(REST)), allow_pickle=False)
        except (OSError, EOFError, KeyError, ValueError, RuntimeError, zipfile.BadZipFile, zlib.error) as error:
            raise ConfigError(f"{field} = '{path}' is not a model of touches: {error}") from None
        return cls(facts=validate(ModelFacts, facts, source=str(path)), network=network, rest=rest)

    def to_bytes(self) -> bytes:
        """The file."""
        rest, file = io.BytesIO(), io.BytesIO()
        np.save(rest, self.rest)
        content = {FACTS: self.facts.model_dump_json(indent=1).encode(), NETWORK: self.network, REST: rest.getvalue()}
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, each in content.items():
                archive.writestr(zipfile.ZipInfo(name), each, zipfile.ZIP_DEFLATED)
        return file.getvalue()

    def refusal(self, design: ElastomerDesign, rig: Rig) -> str | None:
        """What of a sensor the model does not know, in words; None where it knows all."""
        now = sensor_facts(design, rig)
        for name in sorted(each for each in now.keys() | self.facts.sensor.keys() if not each.endswith(SEED)):
            known, value = self.facts.sensor.get(name), now.get(name)
            if isinstance(known, tuple) and isinstance(value, float):
                known = (known[0] - BESIDE * (known[1] - known[0]), known[1] + BESIDE * (known[1] - known[0]))
                slack = 1e-6 * max(1.0, abs(known[0]))
                if known[0] - slack <= value <= known[1] + slack:
                    continue
            elif known == value:
                continue
            allowed = f"{known[0]:g} to {known[1]:g}" if isinstance(known, tuple) else known
            return f"{name} = {value} is not what the model '{self.facts.name}' knows ({allowed})"
        blur, known_px = blurred_px(rig.camera), self.facts.blur_px
        if abs(blur - known_px) > SAME_BLUR_PX:
            allowed = f"{max(0, known_px - SAME_BLUR_PX):.2g} to {known_px + SAME_BLUR_PX:.2g}"
            what = f"a blur of {blur:.2g} px by camera.blur_px and camera.diffraction"
            return f"{what} is not what the model '{self.facts.name}' knows ({allowed})"
        return None

    def predict(self, fields: Fields) -> FloatImage:
        """What the network says, shape (rows, columns, 3), in units of the mean untouched radiance.

        Args:
            fields: Of one touch, see `FieldMaker`.
        """
        rows, columns = 2 * fields.shape[1], 2 * fields.shape[2]
        (name,) = (each.name for each in self._session.get_inputs())
        change = self._session.run(None, {name: filled(fields)[None]})[0]
        return np.asarray(change[0].transpose(1, 2, 0)[:rows, :columns], np.float32)

    @cached_property
    def _session(self) -> Any:  # noqa: ANN401 - it has no types
        import onnxruntime

        from magicsim.light.backend import dr

        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = dr.thread_count()  # as the renderer; pictures do not depend on it
        try:
            return onnxruntime.InferenceSession(self.network, options, providers=["CPUExecutionProvider"])
        except Exception:  # one class for each way in which it is damaged
            raise ConfigError(f"the network of the model '{self.facts.name}' is damaged") from None


def sensor_facts(design: ElastomerDesign, rig: Rig) -> dict[str, str | float]:
    """Settings that a picture depends on, by their paths: numbers, and all else as text; rooms are none of them."""
    data = {
        "design": design.model_dump(mode="json", exclude=UNSEEN | {"materials"}),
        "materials": design.materials.model_dump(mode="json", exclude=UNSEEN_OF_MATERIALS),
        "rig": rig.model_dump(mode="json", include=set(LIGHTS)),
        "camera": rig.camera.model_dump(mode="json", include=set(OPTICAL_CAMERA)),
    }
    return {name: _as_fact(value) for name, value in dotted(data).items()}


def _as_fact(value: object) -> str | float:
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return float(str(value)) if is_number else str(value)


def rest_key(design: ElastomerDesign, rig: Rig) -> str:
    """Digest of a sensor and its room."""
    return hashlib.sha256(untouched_key(design, rig, RenderSettings()).encode()).hexdigest()


def coarse(rest: FloatImage) -> npt.NDArray[np.float32]:
    """An untouched image, coarse and in units of its mean."""
    size = (max(1, rest.shape[1] // COARSE_PX), max(1, rest.shape[0] // COARSE_PX))
    return np.asarray(cv2.resize(rest / rest.mean(), size, interpolation=cv2.INTER_AREA), np.float32)


@lru_cache(maxsize=4)
def _read(path: Path, _changed: int) -> TouchModel:
    return TouchModel.read(path)


def find_model(name: str | None, design: ElastomerDesign, rig: Rig) -> tuple[TouchModel | None, str]:
    """The model for a sensor and no words, or none and why.

    Args:
        name: Its file; by default one that comes with the program.
        design: The block.
        rig: What surrounds it.

    Raises:
        ConfigError: The named file does not exist or is not a model.
    """
    paths = [Path(name)] if name is not None else sorted((preset_root() / MODELS).glob(f"*{MODEL_SUFFIX}"))
    reason = "no model comes with the program for this design and rig; `magicsim distil` makes one"
    for path in paths:
        try:
            changed = path.stat().st_mtime_ns
        except OSError as error:
            raise ConfigError(f"render.model = '{path}' cannot be read: {error.strerror}") from None
        model = _read(path.absolute(), changed)
        refused = model.refusal(design, rig)
        if refused is None:
            return model, ""
        reason = refused if name is not None else f"{refused}; `magicsim distil` makes another"
    return None, reason
