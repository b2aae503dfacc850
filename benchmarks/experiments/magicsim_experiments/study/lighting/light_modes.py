"""Light: which ways it takes through the walls of the grid, and what a touch and a room do to its colours."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from magicsim.config.models import validate
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects.kinds import ObjectConfig
from magicsim.scenes.rig import DARK, Radiance, Rig
from magicsim.scenes.scene import RenderSettings, SceneConfig
from magicsim_experiments.study.lighting.color_measures import (
    CHANNELS,
    SIDES,
    around,
    brightening,
    disparity,
    share_brighter,
    unevenness,
)
from magicsim_experiments.study.lighting.wall_modes import refuse_unlike, wall_modes
from magicsim_experiments.study.plots import Series, plot_series
from magicsim_experiments.study.protocol import Cell, Column, Figure, Row, Study, StudyConfig, StudyResult, Table
from magicsim_experiments.study.stages import PiecesStage, read_pieces, read_refusals

DRAWS = 10
"""Draws of paths, whose spread is the standard error."""
KINDS = ("refraction alone", "external reflection", "internal reflection", "both reflections")
LEGS = ("from light to camera", "from the last scattering to the camera")
EVENTS = ("external_reflections", "internal_reflections", "refractions", "scatterings", "outer_reflections")
FRAMES = ("rest", "light", "heavy")
NOTES = (
    "External reflection: at a wall of a cell, back into the medium of the smaller index; internal reflection: back "
    "into that of the larger one, total reflection included; refraction: through the wall.",
    "Ways are followed from the camera through the print at rest, as drawn; every way refracts at walls. The infill's "
    "index is assumed, and decides: with the body's there is nothing to reflect.",
    "Disparity is the channels' standard deviation over their mean, pixel by pixel, around the contact; unevenness the "
    "deviation over the mean of a channel over the image at rest, cells smoothed away. Frames are of 8 bits.",
)


class LightModesConfig(StudyConfig):
    """Settings of the study."""

    kind: Literal["light-modes"]
    infill_iors: Annotated[tuple[Annotated[float, Field(ge=1, le=2.5)], ...], Field(min_length=1, max_length=20)]
    """Refractive indices of the infill that ways are followed with; the design's own is the headline's if it is one."""
    paths: Annotated[int, Field(ge=100, le=100_000_000)] = 1_000_000
    """Ways for each index."""
    rigs: dict[str, Rig]
    """Lights under which the print is touched, by name; a file may give a list of rig presets instead."""
    room: str = "office"
    """Room of the touches under room light, see `Rig.room`."""
    ambient: tuple[Radiance, Radiance, Radiance] = (0.1, 0.1, 0.1)
    """Mean radiance of the room."""
    object: ObjectConfig
    """What touches."""
    depths_mm: tuple[Annotated[float, Field(gt=0, le=25)], Annotated[float, Field(gt=0, le=25)]] = (0.3, 1.2)
    """Depths of a light and a heavy touch [mm]."""
    exposure_grey: Annotated[float, Field(ge=1, le=254)] = 60.0
    camera_scale: Annotated[float, Field(gt=0, le=1)] = 1.0
    """Rows and columns of the camera against the rig's."""
    render: RenderSettings = RenderSettings()

    @classmethod
    def completed(cls, data: dict[str, Any], *, folder: Path, quick: bool) -> dict[str, Any]:
        """The file's content with the rigs in place."""
        from magicsim_experiments.study.study_file import named_table

        rigs = data.get("rigs", [])
        if isinstance(rigs, list):
            data = data | {"rigs": {Path(str(each)).stem: named_table(each, "rig", folder) for each in rigs}}
        return data


@dataclass(frozen=True, slots=True, kw_only=True)
class ModesTask:
    """Ways through one print, one draw."""

    design: ElastomerDesign
    rig: Rig
    paths: int
    seed: int


def followed(task: ModesTask) -> bytes:
    """Radiance by light and kinds of ways, and mean events, as JSON."""
    found = wall_modes(task.design, task.rig, paths=task.paths, seed=task.seed)
    values = {
        "lights": found.lights, "radiance": found.radiance.tolist(), "events": found.events.tolist(), "lost": found.lost
    }  # fmt: skip
    return (json.dumps(values) + "\n").encode()


def touched(scene: SceneConfig) -> bytes:
    """Measures of the frames of nothing, a light and a heavy touch, as JSON."""
    from magicsim.simulation.plan import plan_scene
    from magicsim.simulation.sensor import Sensor
    from magicsim.simulation.stream import stream_frames

    sensor = Sensor.for_scene(scene)
    frames = [each for each in stream_frames(sensor, plan_scene(scene)) if not each.truth.is_reference]
    images, mask = [each.image for each in frames], frames[-1].contact_mask
    assert mask is not None
    where = around(mask)
    values = {
        "unevenness": unevenness(images[0]), "disparity": [disparity(image, where) for image in images],
        "change": brightening(images[0], images[-1], where), "brighter": share_brighter(images[0], images[-1], where),
    }  # fmt: skip
    return (json.dumps(values) + "\n").encode()


class LightModes(Study):
    """The study `light-modes`."""

    settings = LightModesConfig
    config: LightModesConfig

    def __init__(self, config: LightModesConfig) -> None:
        super().__init__(config)
        seeds = np.random.SeedSequence([config.seed, 10]).generate_state(DRAWS) >> 1
        paths = -(-config.paths // DRAWS)
        modes = [
            ModesTask(design=_with_ior(config.design, ior), rig=config.rig, paths=paths, seed=int(seed))
            for ior in config.infill_iors
            for seed in seeds
        ]
        seconds = 1.0 + 5e-6 * config.paths / DRAWS
        self._modes = PiecesStage(name="ways", function=followed, tasks=modes, seconds=seconds)
        self._lit = [(name, room) for name in config.rigs for room in (DARK, config.room)]
        camera = config.rig.camera
        pixels = camera.rows * camera.columns * config.camera_scale**2
        self._touches = PiecesStage(
            name="touches", function=touched, tasks=[self._scene(*each) for each in self._lit],
            seconds=20.0 + pixels * (config.render.anchor_samples + 8 * config.render.samples) * 4e-6,
        )  # fmt: skip

    def refuse(self) -> None:
        """Refuses what the paths cannot be followed in, before any work."""
        refuse_unlike(self.config.design, self.config.rig)

    def stages(self) -> Sequence[PiecesStage]:
        """Ways through the print, then touches under lights."""
        return [self._modes, self._touches]

    def conclude(self, folder: Path) -> StudyResult:
        """Shares of radiance by kind of way, and the trends that were published, measured."""
        found = [None if each is None else json.loads(each) for each in read_pieces(folder, self._modes)]
        lost = [(each.name, *piece) for each in self.stages() for piece in read_refusals(folder, each).items()]
        draws = {ior: found[k * DRAWS : (k + 1) * DRAWS] for k, ior in enumerate(self.config.infill_iors)}
        groups = {ior: [each for each in group if each is not None] for ior, group in draws.items() if any(group)}
        modes = tuple(row for ior, group in groups.items() for row in mode_rows(ior, group))
        events = tuple(row for ior, group in groups.items() for row in event_rows(ior, group))
        touches = [None if each is None else json.loads(each) for each in read_pieces(folder, self._touches)]
        seen = [(*lit, each) for lit, each in zip(self._lit, touches, strict=True) if each is not None]
        infill = self.config.design.materials.infill
        headline: dict[str, Cell] = {
            f"{'' if row['part'] == LEGS[0] else 'last leg, '}{row['kind']}": row["share"]
            for row in modes
            if infill is not None and row["infill_ior"] == infill.ior
        }
        colors: list[Row] = []
        sides: list[Row] = []
        for rig, room, each in seen:
            uneven = {f"uneven_{name}": value for name, value in zip(CHANNELS, each["unevenness"], strict=True)}
            apart = {f"disparity_{name}": value for name, value in zip(FRAMES, each["disparity"], strict=True)}
            colors.append({"rig": rig, "room": room, **uneven, **apart, "brighter": each["brighter"]})
            for channel, change in each["change"].items():
                sides.append({"rig": rig, "room": room, "channel": channel, **change})
        return StudyResult(
            headline=headline,
            tables=(
                Table(
                    name="ways", title="Radiance of the strips at the camera by ways through the walls",
                    columns=MODE_COLUMNS, rows=modes, shown=100,
                ),
                Table(
                    name="events", title="Mean number of events on a way, weighted by radiance",
                    columns=(Column(name="infill_ior", title="index of the infill"), Column(name="light"),
                             *(Column(name=name, digits=2) for name in EVENTS)),
                    rows=events,
                ),
                Table(name="colors", title="Colours at rest and touched", columns=COLOR_COLUMNS, rows=tuple(colors)),
                Table(
                    name="sides", title="Change around a heavy touch by side",
                    columns=(Column(name="rig"), Column(name="room"), Column(name="channel"),
                             *(Column(name=side, unit="grey levels", digits=1) for side in SIDES)),
                    rows=tuple(sides),
                ),
            ),
            figures=(_figure(modes),) if len(self.config.infill_iors) > 1 else (),
            facts={
                "Ways": f"{self.config.paths} for each index", "Object": self.config.object.kind,
                "Depths": " and ".join(f"{each:g} mm" for each in self.config.depths_mm),
            },
            notes=(*NOTES, *(f"Piece {number} of {name} has no answer: {why}." for name, number, why in lost)),
        )  # fmt: skip

    def _scene(self, name: str, room: str) -> SceneConfig:
        config = self.config
        rig = config.rigs[name].model_dump() | {"room": room, "ambient": (0.0,) * 3 if room == DARK else config.ambient}
        camera = rig["camera"]
        camera |= {key: max(8, round(camera[key] * config.camera_scale)) for key in ("columns", "rows")}
        camera |= {"exposure_grey": config.exposure_grey}
        light, heavy = config.depths_mm
        scene = {
            "schema_version": 1, "design": config.design.model_dump(), "rig": rig, "references": 1, "seed": config.seed,
            "object": config.object.model_dump(), "render": config.render.model_dump(),
            "keyframes": [{"frame": 0}, {"frame": 1, "gap_mm": -light}, {"frame": 2, "gap_mm": -heavy}],
            "output": {"contact_mask": True, "displacements": False, "preview": False, "report": False},
        }  # fmt: skip
        return validate(SceneConfig, scene, source=f"rig '{name}' in '{room}'")


MODE_COLUMNS = (
    Column(name="infill_ior", title="index of the infill"), Column(name="part", title="part of the way"),
    Column(name="kind", title="turned at walls by"), Column(name="share", digits=4),
    Column(name="se", title="standard error", digits=4),
    *(Column(name=name, title=f"share of {name}", digits=4) for name in CHANNELS),
)  # fmt: skip
COLOR_COLUMNS = (
    Column(name="rig"), Column(name="room"),
    *(Column(name=f"uneven_{name}", title=f"unevenness of {name}") for name in CHANNELS),
    *(Column(name=f"disparity_{name}", title=f"disparity, {name}") for name in FRAMES),
    Column(name="brighter", title="pixels that brighten"),
)  # fmt: skip


def mode_rows(ior: float, draws: Sequence[dict[str, Any]]) -> Iterator[Row]:
    """Shares of the strips' radiance, mean over channels and each channel's, with standard errors over `followed`."""
    radiance = np.array([np.array(each["radiance"])[:-1].sum(0) for each in draws])  # the room is the last light
    for place, title in enumerate(LEGS):
        kinds = radiance.sum(2 - place)  # draws, kinds, channels
        of_all = kinds.sum(2) / kinds.sum((1, 2))[:, None]
        channels = kinds.sum(0) / np.maximum(kinds.sum((0, 1)), 1e-300)
        for number, kind in enumerate(KINDS):
            shares = {name: float(channels[number, k]) for k, name in enumerate(CHANNELS)}
            error = float(of_all[:, number].std(ddof=1) / np.sqrt(len(draws))) if len(draws) > 1 else None
            yield {
                "infill_ior": ior, "part": title, "kind": kind, "share": float(of_all[:, number].mean()), "se": error,
                **shares,
            }  # fmt: skip


def event_rows(ior: float, draws: Sequence[dict[str, Any]]) -> Iterator[Row]:
    """Mean events on a way from draws of `followed`, a row a light; lights that send nothing are left out."""
    lit = np.sum([np.sum(each["radiance"], axis=(1, 2, 3)) for each in draws], axis=0)
    events = np.mean([each["events"] for each in draws], axis=0)
    for number, light in enumerate(draws[0]["lights"]):
        if lit[number] > 0:
            yield {"infill_ior": ior, "light": light, **dict(zip(EVENTS, map(float, events[number]), strict=True))}


def _figure(modes: Sequence[Row]) -> Figure:
    """Shares on the whole way against the index of the infill."""
    own = [row for row in modes if row["part"] == LEGS[0]]
    series = [
        Series(
            name=kind, x=[float(str(row["infill_ior"])) for row in own if row["kind"] == kind],
            y=[float(str(row["share"])) for row in own if row["kind"] == kind],
        )
        for kind in KINDS
    ]  # fmt: skip
    svg = plot_series(
        series, x_title="index of the infill", y_title="share of the strips' radiance", name="ways",
        label="Share of radiance by what turned it at walls, against the index of the infill",
    )  # fmt: skip
    return Figure(name="ways", title="What walls turn, by the index of the infill", svg=svg)


def _with_ior(design: ElastomerDesign, ior: float) -> ElastomerDesign:
    infill = design.materials.infill
    if infill is None:
        return design
    materials = design.materials.model_copy(update={"infill": infill.model_copy(update={"ior": ior})})
    return design.model_copy(update={"materials": materials})
