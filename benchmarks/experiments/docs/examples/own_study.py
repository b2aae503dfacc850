"""A study of one's own, in a script: how the force of a press grows with its depth, by the radius of the ball.

python benchmarks/experiments/docs/examples/own_study.py OUT      # presses two balls; half a minute
"""

import json
import sys
from pathlib import Path
from typing import Literal

from magicsim import load_object, press
from magicsim_experiments.study.plots import Series, plot_series
from magicsim_experiments.study.protocol import Column, Figure, Study, StudyConfig, StudyResult, Table
from magicsim_experiments.study.running import run_study
from magicsim_experiments.study.stages import PiecesStage, read_pieces
from magicsim_experiments.study.study_file import load_study


class BallConfig(StudyConfig):
    """Settings of the study."""

    kind: Literal["balls"]
    radii_mm: tuple[float, ...] = (3.0, 6.0)
    depth_mm: float = 0.5


def ball_force(task: tuple[BallConfig, float]) -> bytes:
    """Force of one ball [N], from the solver."""
    config, radius = task
    ball = load_object(f"sphere:radius_mm={radius}")
    found = press(config.design, ball, depth_mm=config.depth_mm)
    return json.dumps({"radius_mm": radius, "force_n": found.force_n[2]}).encode()


class Balls(Study):
    """The study `balls`."""

    settings = BallConfig

    def __init__(self, config: BallConfig) -> None:
        """Takes the settings, and lays out a press of each ball."""
        super().__init__(config)
        tasks = [(config, radius) for radius in config.radii_mm]
        self.presses = PiecesStage(name="presses", function=ball_force, tasks=tasks, seconds=5.0)

    def stages(self) -> list[PiecesStage]:
        """One stage: the presses."""
        return [self.presses]

    def conclude(self, folder: Path) -> StudyResult:
        """A row and a point a ball."""
        rows = tuple(json.loads(each) for each in read_pieces(folder, self.presses) if each is not None)
        series = Series(name="ball", x=[row["radius_mm"] for row in rows], y=[row["force_n"] for row in rows])
        drawn = plot_series([series], x_title="radius [mm]", y_title="force [N]", name="force", label="Force by radius")
        columns = (Column(name="radius_mm", unit="mm"), Column(name="force_n", unit="N"))
        return StudyResult(
            headline={"most_n": max(row["force_n"] for row in rows)},
            tables=(Table(name="balls", title="Force by radius", columns=columns, rows=rows),),
            figures=(Figure(name="force", title="Force by radius", svg=drawn),),
        )


if __name__ == "__main__":
    out = Path(sys.argv[1])
    file = out.with_name("balls.toml")
    file.write_text('schema_version = 1\nkind = "balls"\ndesign = "uniform-block"\n')
    study = load_study(file, kinds={"balls": f"{__name__}:Balls"})
    print(run_study(study, out).headline)
