"""A study of a closed form, to hold the framework: how far a cantilever of the design's height bends."""

import json
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from magicsim.errors import ConfigError, ConvergenceError
from magicsim_experiments.study.plots import Series, plot_series
from magicsim_experiments.study.protocol import Column, Figure, Matrix, Study, StudyConfig, StudyResult, Table
from magicsim_experiments.study.stages import PiecesStage, read_pieces, read_refusals

KINDS = {"beam": f"{__name__}:Beam"}
CALLS: list[float] = []


class BeamConfig(StudyConfig):
    """Settings of `Beam`."""

    kind: Literal["beam"]
    forces_n: tuple[Annotated[float, Field(ge=0)], ...] = (1.0, 2.0, 3.0)


def deflection(task: tuple[float, float]) -> bytes:
    """Deflection of the tip, F L^3 / (3 E I) with L = 10 mm, E = 1 MPa and a square section."""
    force, height = task
    CALLS.append(force)
    if force > 9:
        msg = "the beam buckles"
        raise ConvergenceError(msg)
    if force == 7:
        msg = "out of luck"
        raise RuntimeError(msg)
    return json.dumps({"mm": force * 1000.0 / (3 * height**4 / 12)}).encode()


class Beam(Study):
    """The study."""

    settings = BeamConfig

    def __init__(self, config: BeamConfig) -> None:
        super().__init__(config)
        tasks = [(force, config.design.height_mm) for force in config.forces_n]
        self.stage = PiecesStage(name="tips", function=deflection, tasks=tasks, seconds=0.5)

    def refuse(self) -> None:
        if not self.config.design.has_grid:
            msg = "study 'beam' needs a design with a grid: design.cell_mm = 0"
            raise ConfigError(msg)

    def stages(self) -> list[PiecesStage]:
        return [self.stage]

    def conclude(self, folder: Path) -> StudyResult:
        found = [None if each is None else json.loads(each)["mm"] for each in read_pieces(folder, self.stage)]
        rows = tuple(
            {"force_n": force, "tip_mm": tip, "why": read_refusals(folder, self.stage).get(place)}
            for place, (force, tip) in enumerate(zip(self.config.forces_n, found, strict=True))
        )
        bent = [(row["force_n"], row["tip_mm"]) for row in rows if row["tip_mm"] is not None]
        series = Series(name="tip", x=[each[0] for each in bent], y=[each[1] for each in bent])
        columns = (Column(name="force_n", unit="N"), Column(name="tip_mm", unit="mm"), Column(name="why"))
        return StudyResult(
            headline={"most_mm": max(each[1] for each in bent)},
            tables=(Table(name="tips", title="Tips", columns=columns, rows=rows),),
            matrices=(
                Matrix(
                    name="answers", title="Answers", truths=("a", "b"), answers=("a", "b"),
                    counts=np.array([[3, 1], [0, 2]]), right=np.eye(2, dtype=bool),
                ),
            ),
            figures=(Figure(name="tip", title="Tip", svg=plot_series(
                [series], x_title="force [N]", y_title="tip [mm]", name="tip", label="Tip against force")),),
            notes=("A beam <of> theory.",),
        )  # fmt: skip
