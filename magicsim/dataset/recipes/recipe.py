"""A recipe: distributions over sensors, objects and paths. The configuration of `scenes/recipes/*.toml`."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from magicsim.config.models import Config, load_preset
from magicsim.config.named_files import config_digest
from magicsim.dataset.recipes.entries import (
    ClearPath,
    Draw,
    FlashlightPath,
    ObjectRecipe,
    PathRecipe,
    TouchPath,
    Weight,
)  # fmt: skip
from magicsim.geometry.design import ElastomerDesign
from magicsim.sampling.distribution import Number, Sampling, weights_problem
from magicsim.scenes.rig import DARK, Rig
from magicsim.scenes.scene import FRAMES_PER_SECOND, ContactSettings, FrameRate, RenderSettings, Seed, TaxelSettings


class RoomRecipe(Config):
    """A room, and how bright it is against the LED strips."""

    room: Annotated[str, Field(max_length=1000)] | None = None
    """Room as in `rig.room`: a preset, `dark`, or an image; even light by default."""
    ambient: Number = 0.1
    """Mean radiance of all channels, in the units of the strips' radiance; of no meaning in the dark."""
    weight: Weight = 1.0
    """How often this entry is chosen, relative to the others."""

    def _problems(self) -> Iterator[str | None]:
        if self.room is not None and self.room != DARK:
            from magicsim.scenes.room import room_file

            room_file(self.room)  # raises
        yield None

    def numbers(self) -> dict[str, Number]:
        """What may be drawn, by name."""
        return {"ambient": self.ambient}

    def placed(self, rig: dict[str, Any], draw: Draw) -> dict[str, Any]:
        """A rig's settings in this room."""
        return rig | {"room": self.room, "ambient": (draw("ambient", self.ambient),) * 3}


MAX_SENSORS = 100_000
"""Most printed sensors: each has a row in `sensors.parquet`, which is made before the first episode."""
IN_TABLES = {
    "exposure_ms": ("shutter", "exposure_ms"), "flicker_depth": ("flicker", "depth"),
    "led_drift_share": ("led_drift", "share"), "glare_share": ("glare", "share"), "dark_e": ("faults", "dark_e"),
    "row_e": ("faults", "row_e"), "live_frames": ("live", "time_constant_frames"),
}  # fmt: skip
"""Tables of the camera that drawn values belong to, and their keys there."""
Share = Annotated[float, Field(ge=0, le=1)]


class Splits(Config):
    """Parts of the dataset, relative."""

    train: Share = 0.8
    validation: Share = 0.1
    test: Share = 0.1

    def _problems(self) -> Iterator[str | None]:
        yield weights_problem((self.train, self.validation, self.test), 3)

    def shares(self) -> dict[str, float]:
        """Weight of each split that is not empty."""
        return {name: getattr(self, name) for name in ("train", "validation", "test") if getattr(self, name) > 0}


class Tolerances(Config):
    """How one printed sensor differs from the next."""

    skin_mm: Number = 0.0
    """Added to the design's skin [mm]."""
    wall_mm: Number = 0.0
    """Added to the walls and taken from the cells: the pitch is what was printed [mm]."""
    body_ior: Number = 0.0
    """Added to the body's refractive index."""
    infill_ior: Number = 0.0
    """Added to the infill's refractive index."""
    stiffness: Number = 1.0
    """Factor on the elastic moduli of body and infill."""
    wall_spread_mm: Number = 0.0
    """`unevenness.wall_sd_mm` of the print, beside the design's [mm]."""
    wave_mm: Number = 0.0
    """`unevenness.wave_sd_mm` of the print, beside the design's [mm]."""
    skin_spread_mm: Number = 0.0
    """`unevenness.skin_sd_mm` of the print, beside the design's [mm]."""
    pitch_scale: Number = 1.0
    """Factor on the design's `unevenness.pitch_scale`, drawn for each axis."""
    pitch_drift: Number = 0.0
    """Added to the design's `unevenness.pitch_drift`, drawn for each axis."""
    torn_share: Number = 0.0
    """Added to the design's `unevenness.torn_share`."""
    skin_roughness: Number = 0.0
    """Added to the design's `roughness.skin`."""
    wall_roughness: Number = 0.0
    """Added to the design's `roughness.walls`."""
    bubbles_per_mm3: Number = 0.0
    """Added to the design's `inclusions.bubbles_per_mm3` [1/mm3]."""
    flakes_per_mm3: Number = 0.0
    """Added to the design's `inclusions.flakes_per_mm3` [1/mm3]."""
    led_strength: Number = 1.0
    """Factor on each LED strip, single LED and ring, drawn for each."""
    led_color: Number = 1.0
    """Factor on each channel of each of them, drawn for each: LEDs of one kind differ in colour."""


class CameraNoise(Config):
    """What the camera does differently in each episode; left out means as the rig says.

    A value of a table of `rig.camera` turns that table on where the rig leaves it out.
    """

    exposure_grey: Number | None = None
    full_well_e: Number | None = None
    read_noise_e: Number | None = None
    vibration_px: Number | None = None
    """Vibration of the whole image [px]."""
    exposure_ms: Number | None = None
    """`shutter.exposure_ms`."""
    flicker_depth: Number | None = None
    """`flicker.depth`."""
    led_drift_share: Number | None = None
    """`led_drift.share`."""
    glare_share: Number | None = None
    """`glare.share`."""
    dark_e: Number | None = None
    """`faults.dark_e`."""
    row_e: Number | None = None
    """`faults.row_e`."""
    live_frames: Number | None = None
    """`live.time_constant_frames`."""

    def placed(self, camera: dict[str, Any], values: Mapping[str, float]) -> dict[str, Any]:
        """A camera's settings with drawn values in their places."""
        settings = dict(camera)
        for name, value in values.items():
            table, key = IN_TABLES.get(name, ("", name))
            if table:
                settings[table] = (settings.get(table) or {}) | {key: value}
            else:
                settings[key] = value
        return settings


class Labels(Config):
    """Which of the large labels are written."""

    contact_mask: bool = True
    """Contact in image space."""
    depth_map: bool = True
    """How far the contact face is pressed in, in image space."""
    displacements: bool = True
    """Displacements of every lattice node."""
    taxels: TaxelSettings | None = None
    """Forces on a grid of taxels, stretch and stress of the skin, shear of the infill; none by default."""


class Recipe(Config):
    """What a dataset is drawn from."""

    schema_version: Literal[1]
    design: ElastomerDesign
    """The block; a file may give the name of a design preset instead."""
    rig: Rig
    """What surrounds it; a file may give the name of a rig preset instead."""
    seed: Seed = 0
    """Seed of everything random."""
    episodes: Annotated[int, Field(ge=1, le=10_000_000)]
    """How many; a dataset may grow later."""
    episodes_per_sensor: Annotated[int, Field(ge=1, le=10_000_000)] = 8
    """Consecutive episodes of one printed sensor."""
    episodes_per_shard: Annotated[int, Field(ge=1, le=1000)] = 16
    """Episodes of one split in one file."""
    sampling: Sampling = "stratified"
    """Stratified points cover each distribution evenly and tie none to another. Of Sobol points, of dozens as of a
    thousand, the choice of an object tells where it touches: they draw older datasets again."""
    split_by: Literal["episode", "sensor"] = "episode"
    """What is never in two splits."""
    splits: Splits = Splits()
    touches: Annotated[Annotated[int, Field(ge=1, le=10_000_000)] | None, Field(exclude=True)] = None
    """In place of `episodes` where every path is a touch."""
    inside: bool = True
    """Whether drawn places of objects are inside of the picture, which may cover less than the face."""
    references: Annotated[int, Field(ge=0, le=1000)] = 1
    """Frames of the untouched sensor before each episode."""
    frames_per_second: FrameRate = FRAMES_PER_SECOND
    tolerances: Tolerances = Tolerances()
    camera: CameraNoise = CameraNoise()
    rooms: tuple[RoomRecipe, ...] = ()
    """Where the sensors stand, one of them for each; the rig's own room where none is given."""
    objects: tuple[ObjectRecipe, ...] = ()
    paths: Annotated[tuple[PathRecipe, ...], Field(min_length=1)]
    contact: ContactSettings = ContactSettings()
    """How skin and object meet; friction is that of each path."""
    render: RenderSettings = RenderSettings()
    labels: Labels = Labels()
    license: Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9.-]{0,59}$")] | None = None
    """What the dataset's card names as its licence, such as `cc-by-4.0`: yours to choose, none by default."""
    timeout_s: Annotated[float, Field(ge=0.001, le=1e6)] = 1800.0
    """Longest time for one attempt at an episode [s]."""

    @model_validator(mode="before")
    @classmethod
    def _count_touches(cls, data: Any) -> Any:  # noqa: ANN401 - whatever a file holds
        return data | {"episodes": data["touches"]} if isinstance(data, dict) and data.get("touches") else data

    def _problems(self) -> Iterator[str | None]:
        for number, path in enumerate(self.paths):
            if self.touches is not None and not isinstance(path, TouchPath):
                yield (
                    f"touches = {self.touches} is not allowed: paths.{number} is of kind '{path.kind}' and not a "
                    "touch; set episodes"
                )
            if isinstance(path, TouchPath) and path.force_n is not None and self.contact.rate_dependent:
                yield (
                    f"paths.{number}.force_n is not allowed with contact.rate_dependent: how deep a force presses "
                    "depends on time there; set depth_mm"
                )
        if self.contact.friction:
            yield f"contact.friction = {self.contact.friction:g} is not allowed in a recipe: set paths.friction"
        if not self.objects and not all(isinstance(path, ClearPath | FlashlightPath) for path in self.paths):
            yield "objects are missing: a path brings an object, so [[objects]] must say which"
        sensors = -(-self.episodes // self.episodes_per_sensor)
        if sensors > MAX_SENSORS:
            yield (
                f"episodes = {self.episodes} with episodes_per_sensor = {self.episodes_per_sensor} are {sensors} "
                f"sensors: at most {MAX_SENSORS} are allowed; raise episodes_per_sensor"
            )

    @property
    def may_pass(self) -> bool:
        """Whether something passes in any of the rooms."""
        rooms = [self.rig.model_copy(update={"room": each.room}) for each in self.rooms] or [self.rig]
        return any(rig.moving is not None for rig in rooms)

    def config_hash(self) -> str:
        """SHA-256 of all that rows depend on, files included: neither of their number, nor of time or licence."""
        data = self.model_dump(mode="json", exclude={"episodes", "license", "timeout_s"})
        return config_digest(data)


def load_recipe(name: str | Path, overrides: Sequence[str] = (), *, seed: int | None = None) -> Recipe:
    """Reads a recipe by preset name or path and puts its design and rig in place.

    Overrides are `dotted.key=value`; `design.` and `rig.` reach into those files. A seed stands for the file's.

    Raises:
        PresetError: The recipe, its design or its rig does not exist.
        ConfigError: The content is not acceptable.
    """
    return load_preset(Recipe, "recipe", name, overrides, seed=seed)
