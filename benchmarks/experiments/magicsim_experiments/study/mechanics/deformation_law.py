"""What the printed grid does under force, shear and twist, and what the image shows of it by optical flow."""

import io
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field

from magicsim.arrays import Array
from magicsim.camera.projection import pixel_landing_mm
from magicsim.errors import ConfigError
from magicsim.geometry.design import MAX_DEPTH_SHARE
from magicsim.geometry.objects.kinds import ObjectConfig
from magicsim.scenes.scene import RenderSettings
from magicsim_experiments.study.mechanics.law_scene import (
    LawTask,
    Touch,
    angle_between_deg,
    direction_deg,
    extent_mm,
    moved_places,
    optical_flow_px,
    touch_fields,
    turn_deg,
)
from magicsim_experiments.study.plots import Series, plot_series
from magicsim_experiments.study.protocol import (
    Cell,
    Figure,
    Row,
    Study,
    StudyConfig,
    StudyResult,
    Table,
    columns_of,
)
from magicsim_experiments.study.stages import PiecesStage, read_pieces, read_refusals

Fields = Mapping[str, npt.NDArray[Any]]
Length = Annotated[float, Field(gt=0, le=25)]
Angle = Annotated[float, Field(ge=-360, le=360)]
HEADS = {
    "fx_n": "Fx", "fy_n": "Fy", "fz_n": "Fz", "torque_nmm": "torque about z", "grid_mm": "grid moved",
    "grid_extent_mm": "radius of what moved", "image_px": "image moved", "image_change": "mean change of the image",
    "direction_deg": "direction of shear", "grid_error_deg": "error of the grid's direction",
    "image_error_deg": "error of the image's direction", "twist_deg": "twist", "grid_turn_deg": "grid turned",
    "image_turn_deg": "image turned", "grid_sense": "grid turned rightly", "image_sense": "image turned rightly",
}  # fmt: skip
"""Heads of columns on the page."""
MOVED_MM = 0.05
"""Displacement from which a node counts for the extent [mm]."""
SPREAD = 2.0
"""Places up to so many radii of the contact count for direction and turn: beyond, the object has little hold."""
NOTES = (
    "Grid: nodes of the uppermost plane of the printed grid. Shear and twist are what changed after the press.",
    "Image: flow of the pixels of the contact and around it, from the pressed frame to the sheared or twisted one, "
    "with the camera's noise; the grid's own answer is beside it.",
    "Isotropy is (largest - least) / mean of the response over all directions of shear.",
)


class DeformationLawConfig(StudyConfig):
    """Settings of the study."""

    kind: Literal["deformation-law"]
    object: ObjectConfig
    """What touches; a file may give the name of an object preset."""
    friction: Annotated[float, Field(ge=0, le=2)] = 1.0
    depths_mm: Annotated[tuple[Length, ...], Field(min_length=2, max_length=50)]
    """Depths of the presses, increasing."""
    depth_mm: Length = 0.8
    """Depth of the presses that are then sheared or twisted."""
    shear_mm: Length = 0.5
    directions_deg: Annotated[tuple[Angle, ...], Field(min_length=2, max_length=72)]
    twists_deg: Annotated[tuple[Angle, ...], Field(min_length=1, max_length=20)]
    camera_scale: Annotated[float, Field(gt=0, le=1)] = 1.0
    """Rows and columns of the camera against the rig's."""
    render: RenderSettings = RenderSettings()


class DeformationLaw(Study):
    """The study `deformation-law`."""

    settings = DeformationLawConfig
    config: DeformationLawConfig

    def __init__(self, config: DeformationLawConfig) -> None:
        super().__init__(config)
        camera = config.rig.camera
        size = {key: max(8, round(config.camera_scale * getattr(camera, key))) for key in ("rows", "columns")}
        self.rig = config.rig.model_copy(update={"camera": camera.model_copy(update=size)})
        series = (
            tuple(Touch(depth_mm=depth) for depth in config.depths_mm),
            tuple(
                Touch(depth_mm=config.depth_mm, shear_mm=config.shear_mm, direction_deg=angle)
                for angle in config.directions_deg
            ),
            tuple(Touch(depth_mm=config.depth_mm, twist_deg=angle) for angle in config.twists_deg),
        )
        most = max(len(each) for each in series)
        self.touches = PiecesStage(
            name="touches", function=touch_fields, suffix=".npz", seconds=10.0 + 3.0 * most,
            tasks=[
                LawTask(
                    design=config.design, rig=self.rig, object=config.object, friction=config.friction,
                    render=config.render, touches=each, seed=config.seed,
                )
                for each in series
            ],
        )  # fmt: skip

    def refuse(self) -> None:
        """Refuses blocks without a grid and presses through the block."""
        if not self.config.design.has_grid:
            raise ConfigError("study 'deformation-law' needs a printed grid: design.cell_mm = 0")
        deepest = max(*self.config.depths_mm, self.config.depth_mm)
        most = MAX_DEPTH_SHARE * self.config.design.height_mm
        if deepest > most:
            raise ConfigError(f"depths_mm = {deepest:g} is not allowed: at most {most:g}, 90 % of the height")

    def stages(self) -> Sequence[PiecesStage]:
        """Presses, shears and twists."""
        return [self.touches]

    def conclude(self, folder: Path) -> StudyResult:
        """Size and extent by force, direction by shear, turn by twist."""
        refusals = read_refusals(folder, self.touches)
        if refusals:
            raise ConfigError(next(iter(refusals.values())))
        pressed, sheared, twisted = (
            dict(np.load(io.BytesIO(each))) for each in read_pieces(folder, self.touches) if each is not None
        )
        landing = pixel_landing_mm(self.config.design, self.rig.lens, self.rig.camera)
        presses = tuple(press_rows(pressed, self.config.depths_mm))
        shears = tuple(shear_rows(sheared, self.config.directions_deg, landing))
        twists = tuple(twist_rows(twisted, self.config.twists_deg, landing))
        return StudyResult(
            headline={
                "worst_direction_error_deg": max(abs(float(row["grid_error_deg"] or 0)) for row in shears),
                "worst_image_direction_error_deg": max(abs(float(row["image_error_deg"] or 0)) for row in shears),
                "isotropy_of_grid": spread([float(row["grid_mm"] or 0) for row in shears]),
                "isotropy_of_image": spread([float(row["image_px"] or 0) for row in shears]),
                "twists_with_right_sense": sum(bool(row["grid_sense"]) for row in twists),
                "twists_with_right_sense_in_image": sum(bool(row["image_sense"]) for row in twists),
                "twists": len(twists),
            },
            tables=(
                Table(name="press", title="By force", columns=columns_of(presses[0], HEADS), rows=presses),
                Table(name="shear", title="By direction of shear", columns=columns_of(shears[0], HEADS), rows=shears),
                Table(name="twist", title="By twist", columns=columns_of(twists[0], HEADS), rows=twists),
            ),
            figures=_figures(presses),
            facts={"Object": self.config.object.kind, "Friction": f"{self.config.friction:g}"},
            notes=NOTES,
        )


def press_rows(fields: Fields, depths_mm: Sequence[float]) -> Iterator[dict[str, Cell]]:
    """Size and extent of each press, from `touch_fields`."""
    for number, depth in enumerate(depths_mm):
        length = np.linalg.norm(fields["moved_mm"][number], axis=1)
        flow = optical_flow_px(fields["untouched"], fields["image"][number])
        change = np.abs(fields["image"][number].astype(float) - fields["untouched"])
        yield {
            "depth_mm": depth, "fz_n": float(fields["force_n"][number, 2]), "grid_mm": float(length.max()),
            "grid_extent_mm": extent_mm(fields["places_mm"], length, least_mm=MOVED_MM),
            "image_px": float(np.quantile(np.linalg.norm(flow, axis=-1), 0.99)), "image_change": float(change.mean()),
        }  # fmt: skip


def shear_rows(fields: Fields, directions_deg: Sequence[float], landing_mm: Array) -> Iterator[dict[str, Cell]]:
    """Which way grid and image went in each shear.

    Args:
        directions_deg: Of each shear, from x towards y [degrees].
        landing_mm: Where pixels look on the face, shape (rows, columns, 2) [mm].
    """
    for number, direction in enumerate(directions_deg):
        grid, image = _changes(fields, number, landing_mm)
        found, seen = direction_deg(grid[1]), direction_deg(image[1])
        yield {
            "direction_deg": direction, "fx_n": float(fields["force_n"][number, 0]),
            "fy_n": float(fields["force_n"][number, 1]), "grid_mm": float(np.linalg.norm(grid[1].mean(0))),
            "grid_error_deg": angle_between_deg(found, direction),
            "image_px": float(np.linalg.norm(image[1].mean(0))),
            "image_error_deg": angle_between_deg(seen, direction),
        }  # fmt: skip


def twist_rows(fields: Fields, twists_deg: Sequence[float], landing_mm: Array) -> Iterator[dict[str, Cell]]:
    """Which way round grid and image went in each twist, and how far; see `shear_rows`."""
    for number, twist in enumerate(twists_deg):
        grid, image = _changes(fields, number, landing_mm)
        pixel_mm = float(np.linalg.norm(landing_mm[0, 1] - landing_mm[0, 0]))
        found, seen = turn_deg(*grid), turn_deg(image[0], image[1] * pixel_mm)
        yield {
            "twist_deg": twist, "torque_nmm": float(fields["torque_nmm"][number, 2]), "grid_turn_deg": found,
            "grid_sense": found * twist > 0, "image_turn_deg": seen, "image_sense": seen * twist > 0,
        }  # fmt: skip


def spread(values: Sequence[float]) -> float:
    """(Largest - least) / mean of values."""
    return float((max(values) - min(values)) / max(float(np.mean(values)), 1e-12))


def _changes(fields: Fields, number: int, landing_mm: Array) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Places and what changed after the press, of the grid [mm] and of the image [px], x right and y up."""
    moved = (fields["moved_mm"][number] - fields["pressed_mm"][number])[:, :2].astype(float)
    chosen = moved_places(moved)
    area_mm2 = float(np.prod(np.ptp(landing_mm.reshape(-1, 2), axis=0)))  # of the face that is seen
    radius = float(np.sqrt(fields["mask"][number].mean() * area_mm2 / np.pi))
    flow = optical_flow_px(fields["pressed_image"][number], fields["image"][number]) * [1, -1]
    near = np.linalg.norm(landing_mm, axis=-1) < SPREAD * max(radius, 0.5)
    return (fields["places_mm"][chosen], moved[chosen]), (landing_mm[near], flow[near])


def _figures(presses: Sequence[Row]) -> tuple[Figure, ...]:
    forces = [float(row["fz_n"] or 0) for row in presses]
    titles = {"grid_mm": "largest displacement of the grid [mm]", "grid_extent_mm": "radius of what moved [mm]"}
    return tuple(
        Figure(
            name=name, title=title[0].upper() + title[1:],
            svg=plot_series(
                [Series(name="grid", x=forces, y=[float(row[name] or 0) for row in presses])],
                x_title="normal force [N]", y_title=title, name=name.replace("_", "-"), label=f"{title} against force",
            ),
        )
        for name, title in titles.items()
    )  # fmt: skip
