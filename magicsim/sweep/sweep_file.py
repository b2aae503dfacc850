"""A sweep: which fields vary, on which sensor, and how each design is judged. The model of `geometry/sweeps`."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from magicsim.config.models import Config, load_preset
from magicsim.config.named_files import config_digest
from magicsim.dataset.recipes.recipe import IN_TABLES, CameraNoise, Tolerances
from magicsim.errors import unknown_choice
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects.kinds import ObjectConfig
from magicsim.judge.measures import Better
from magicsim.sampling.distribution import Distribution, Value, choose
from magicsim.scenes.rig import Rig, in_room
from magicsim.scenes.scene import RenderSettings, Seed
from magicsim.sweep.measures import DURABILITY, MEASURES, SweepQuality
from magicsim.sweep.result import DesignResult

SHAPES = (
    "skin_mm", "wall_mm", "wall_spread_mm", "wave_mm", "skin_spread_mm", "pitch_scale", "pitch_drift", "torn_share",
    "stiffness",
)  # fmt: skip
"""Tolerances that change meshes or forces, which the renderings of a design share."""
TIMED = ("exposure_ms", "flicker_depth", "led_drift_share", "live_frames")
"""What a camera does in the course of a stream; frames of a film have no times."""
TIMED_FIELDS = tuple(
    f"rig.camera.{each}"
    for each in ("shutter.", "flicker.", "led_drift.", "live.", "compression.crf", "compression.key")
)
"""How fields of the rig's camera begin that are about a stream as well."""
OF_QUALITY = ("samples", "particles", "anchor_samples", "anchor_particles")
"""Settings of `render` that the quality gives."""


MAX_DESIGNS = 10_000
"""Most designs of a sweep."""


class SearchLimit(Config):
    """A measure that has to stay in a range."""

    measure: str
    low: Value | None = None
    """Smallest value that is allowed."""
    high: Value | None = None
    """Largest value that is allowed."""

    def _problems(self) -> Iterator[str | None]:
        if self.measure not in MEASURES:
            yield unknown_choice("measure", self.measure, MEASURES)
        if self.low is None and self.high is None:
            yield f"limit of '{self.measure}' needs low or high"
        if self.low is not None and self.high is not None and self.low > self.high:
            yield f"low = {self.low:g} is not allowed: must be at most high = {self.high:g}"

    def excess(self, result: DesignResult) -> float | None:
        """By how much a design is out of the range, in the measure's unit; 0 or less inside, None without a value."""
        found = result.measures.get(self.measure)
        if found is None or found.value is None:
            return None
        below = self.low - found.value if self.low is not None else -float("inf")
        above = found.value - self.high if self.high is not None else -float("inf")
        return max(below, above)


class SearchSettings(Config):
    """Everything here changes which designs are chosen."""

    start: Annotated[int, Field(ge=1, le=MAX_DESIGNS)] = 16
    """Designs that are spread evenly (Sobol) before the search looks at results."""
    batch: Annotated[int, Field(ge=1, le=MAX_DESIGNS)] = 8
    """Designs that are chosen at once, and judged at the same time; the next batch knows their results."""
    limits: tuple[SearchLimit, ...] = ()
    """What a design has to keep; one that does not is in no Pareto front."""

    def keeps(self, result: DesignResult) -> bool:
        """Whether a design is inside every limit."""
        return all((excess := each.excess(result)) is not None and excess <= 0 for each in self.limits)


ROOTS = ("design", "rig", "render")
"""What the name of a swept field begins with."""
ROOM = "rig.room"
"""The field that may name a file of the user's."""
Setting = Value | Annotated[str, Field(min_length=1, max_length=1000)]
"""What a swept field is set to: a number, or a name, as of a room."""


class SweptField(Config):
    """A field and the values that it takes: either a list, or an interval with, on a grid, a count."""

    field: str
    """Dotted name, such as `design.skin_mm`, `rig.camera.exposure_grey` or `rig.room`; a number counts entries of a
    list."""
    values: Annotated[tuple[Setting, ...], Field(min_length=1)] | None = None
    low: Value | None = None
    high: Value | None = None
    count: Annotated[int, Field(ge=2, le=1000)] | None = None
    """Values of an interval on a grid."""
    scale: Literal["linear", "log"] = "linear"

    def _problems(self) -> Iterator[str | None]:
        root, _, rest = self.field.partition(".")
        if root not in ROOTS or not rest:
            yield unknown_choice("field", self.field, [f"{each}.*" for each in ROOTS])
        if (self.values is None) == (self.low is None and self.high is None):
            yield f"field '{self.field}' needs either values, or low and high"
        if self.values is not None and len(set(self.values)) < len(self.values):
            yield f"values = {list(self.values)} of '{self.field}' is not allowed: holds a value twice"
        if self.values is not None and (self.count is not None or self.scale != "linear"):
            yield f"count and scale of '{self.field}' are not allowed with values: they belong to low and high"
        if self.values is None:
            self._interval()

    def at(self, share: float) -> float | str:
        """The value that a quasi-random number in [0, 1) stands for."""
        if self.values is not None:
            return self.values[choose(share, (1.0,) * len(self.values))]
        return round(self._interval().at(share), 6)

    def on_grid(self) -> tuple[float | str, ...]:
        """Values of the factor on a grid."""
        if self.values is not None:
            return self.values
        count = self.count or 2
        spread = self._interval()
        return tuple(round(spread.at(number / (count - 1)), 9) for number in range(count))

    def _interval(self) -> Distribution:
        return Distribution(low=self.low, high=self.high, scale=self.scale)


class Objective(Config):
    """A measure that is to be as good as possible."""

    measure: str
    better: Better | None = None
    """Which way; may be left out where the measure has a way of its own."""

    def _problems(self) -> Iterator[str | None]:
        if self.measure not in MEASURES:
            yield unknown_choice("measure", self.measure, MEASURES)
        if self.better is None and MEASURES[self.measure].better is None:
            yield f"better is missing: '{self.measure}' may be wanted 'higher' or 'lower'"

    @property
    def direction(self) -> Better:
        """The better direction: the one that is given, or the measure's own."""
        return self.better or MEASURES[self.measure].better or "higher"


class SweepConfig(Config):
    """Designs to compare, and how."""

    schema_version: Literal[1]
    design: ElastomerDesign
    """The base block; a file may give the name of a design preset instead."""
    rig: Rig
    """What surrounds it; a file may give the name of a rig preset instead."""
    rooms: Annotated[tuple[Annotated[str, Field(min_length=1, max_length=1000)], ...], Field(max_length=20)] = ()
    """Rooms that the renderings of every design stand in by turns, each with a camera of its own; see `Rig.room`.
    Without any all stand in the rig's."""
    tolerances: Tolerances = Tolerances()
    """How the print of one rendering differs from the next, as a recipe's `tolerances`, for what light alone sees; the
    numbers are the same for all designs."""
    camera: CameraNoise = CameraNoise()
    """What the camera of a rendering does differently, as a recipe's `camera`; likewise."""
    render: RenderSettings = RenderSettings()
    """Rendering, of which the quality sets samples and particles."""
    object: ObjectConfig
    """What approaches and presses; a file may give the name of an object preset instead."""
    seed: Seed = 0
    """Seed of everything random."""
    sampling: Literal["grid", "sobol", "random", "search"] = "grid"
    """All combinations, or as many points as `count` says: spread evenly, independent, or searched for (Optuna)."""
    count: Annotated[int, Field(ge=1, le=MAX_DESIGNS)] | None = None
    """Designs, where they are no grid."""
    swept: Annotated[tuple[SweptField, ...], Field(min_length=1)]
    also: tuple[dict[str, Setting], ...] = ()
    """Further designs: the base with these fields changed."""
    measures: Annotated[tuple[str, ...], Field(min_length=1)] = tuple(
        name for name in MEASURES if name not in DURABILITY
    )
    """Which measures are taken, by name; those of durability only where they are named."""
    objectives: tuple[Objective, ...] = (Objective(measure="sensitivity_per_n"), Objective(measure="localisation_mm"))
    """What the Pareto front trades; the first one chooses the best design."""
    quality: SweepQuality = SweepQuality()
    search: SearchSettings | None = None
    """How to search, where the sampling is that."""
    timeout_s: Annotated[float, Field(ge=0.001, le=1e6)] = 3600.0
    """Longest time for one attempt at a design [s]."""

    def _problems(self) -> Iterator[str | None]:
        for name in self.measures:
            if name not in MEASURES:
                yield unknown_choice("measure", name, MEASURES)
        for each in self.objectives:
            if each.measure not in self.measures:
                yield unknown_choice("objective", each.measure, self.measures)
        for problems in (self._room_problems, self._draw_problems, self._count_problems, self._search_problems):
            yield from problems()
        names = [each.field for each in self.swept]
        if len(set(names)) < len(names):
            yield f"swept.field = {names} is not allowed: names a field twice"

    def _room_problems(self) -> Iterator[str | None]:
        if self.rooms and any(each.field == ROOM for each in self.swept) | any(ROOM in each for each in self.also):
            yield f"rooms is not allowed where '{ROOM}' is swept: must be one of the two"
        if len(self.rooms) > self.quality.renderings:
            yield (
                f"rooms = {list(self.rooms)} is not allowed: holds {len(self.rooms)}, and each rendering stands in "
                f"one; must be at most quality.renderings = {self.quality.renderings}"
            )
        for each in self.rooms:
            if in_room(self.rig, each).moving is not None:
                yield f"rooms = '{each}' is not allowed: something passes there; sweep '{ROOM}' instead"

    @property
    def draws(self) -> bool:
        """Whether renderings have prints and cameras of their own."""
        return (self.tolerances, self.camera) != (Tolerances(), CameraNoise())

    def _draw_problems(self) -> Iterator[str | None]:
        for table, names, why in (
            ("tolerances", SHAPES, "renderings of a design share its meshes and presses"),
            ("camera", TIMED, "frames of a film have no times"),
        ):
            given = getattr(self, table)
            usual = type(given)()
            for name in names:
                if getattr(given, name) != getattr(usual, name):
                    allowed = ", ".join(each for each in type(given).model_fields if each not in names)
                    yield f"{table}.{name} is not allowed in a sweep, as {why}: must be among {allowed}"
        if self.render.tier == "fast":
            yield "render.tier = 'fast' is not allowed: a sweep's frames are true ones"
        swept = {each.field for each in self.swept} | {name for each in self.also for name in each}
        for field in (*(f"render.{name}" for name in OF_QUALITY), "rig.camera.columns", "rig.camera.rows"):
            if field in swept:
                yield f"{field} is not allowed to be swept: quality.{field.split('.')[-1]} has it for all designs"
        if self.rig.camera.region_px is not None:
            yield "rig.camera.region_px is not allowed in a sweep: its frames show the whole image"
        for field in sorted(each for each in swept if each.startswith(TIMED_FIELDS)):
            yield f"{field} is not allowed to be swept: frames of a film have no times"
        for name in self.camera.model_dump(exclude_none=True):
            if f"rig.camera.{'.'.join(IN_TABLES.get(name, (name,)))}" in swept:
                yield f"camera.{name} is not allowed where that of the rig is swept: must be one of the two"

    def _count_problems(self) -> Iterator[str | None]:
        if len(self.also) > MAX_DESIGNS:
            yield f"also has {len(self.also)} designs: at most {MAX_DESIGNS} are allowed"
        if self.sampling == "grid":
            for each in self.swept:
                if each.values is None and each.count is None:
                    yield f"count is missing: field '{each.field}' is an interval on a grid"
            if self.count is not None:
                yield f"count = {self.count} is not allowed with sampling = 'grid', whose fields say how many"
            total = math.prod(len(each.on_grid()) for each in self.swept)
            if total > MAX_DESIGNS:
                yield f"{total} designs are too many: at most {MAX_DESIGNS}"
        elif self.count is None:
            yield f"count is missing: sampling = '{self.sampling}' needs a number of designs"

    def _search_problems(self) -> Iterator[str | None]:
        if self.sampling != "search":
            if self.search is not None:
                yield f"search is not allowed with sampling = '{self.sampling}'"
            return
        if not self.objectives:
            yield "objectives = [] is not allowed with sampling = 'search'"
        for each in self.search.limits if self.search is not None else ():
            if each.measure not in self.measures:
                yield unknown_choice("limit", each.measure, self.measures)

    def config_hash(self) -> str:
        """SHA-256 of everything that results depend on, files included; a search depends on its objectives."""
        left_out = {"timeout_s"} if self.sampling == "search" else {"timeout_s", "objectives", "search"}
        data = self.model_dump(mode="json", exclude=left_out)
        rooms = [room for each in self.swept if each.field == ROOM for room in each.values or ()]
        rooms += [each[ROOM] for each in self.also if ROOM in each]
        return config_digest(data | ({"rooms": [{"room": each} for each in rooms]} if rooms else {}))


def load_sweep(name: str | Path, overrides: Sequence[str] = (), *, seed: int | None = None) -> SweepConfig:
    """Reads a sweep by preset name or path and puts its design, rig and object in place.

    Args:
        name: Sweep preset or TOML file.
        overrides: `dotted.key=value` settings; `design.` and `rig.` reach into those files.
        seed: Seed instead of the file's.

    Raises:
        PresetError: The sweep, its design, its rig or its object does not exist.
        ConfigError: The content is not acceptable.
    """
    return load_preset(SweepConfig, "sweep", name, overrides, seed=seed)
