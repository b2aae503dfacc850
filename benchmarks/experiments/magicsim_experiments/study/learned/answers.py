"""The answers of a study's models, read from its folder and put together over folds."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from magicsim.arrays import Array, Index, Mask
from magicsim.errors import OutputError
from magicsim_experiments.learn.fitting import ANSWERS, Fit
from magicsim_experiments.study.stages.learning_stage import LearningStage


@dataclass(frozen=True, slots=True, kw_only=True)
class Answers:
    """Truth and answers of all methods on frames that no model of their fold has learned from."""

    table: pa.Table

    def __len__(self) -> int:
        """Number of frames."""
        return int(self.table.num_rows)

    def of(self, method: str, label: str) -> Array:
        """Answers of a method, or `truth`; shape (n,)."""
        return np.asarray(self.table[f"{method}.{label}"].to_numpy(), np.float64)

    def column(self, name: str) -> Index:
        """`press`, `unit`, `group` or `train_frames`; shape (n,)."""
        return np.asarray(self.table[name].to_numpy())

    def where(self, chosen: Mask) -> "Answers":
        """Some of the frames."""
        return Answers(table=self.table.filter(pa.array(chosen)))


def read_answers(folder: Path, stage: LearningStage, prefix: str, name: str = ANSWERS) -> Answers | None:
    """Answers of all fits whose names begin so, one after the other; None where there are none.

    Args:
        prefix: Such as `press`, `unit`, `share-250` or a network's name.
    """
    paths = [stage.folder(folder, fit) / name for fit in fits_of(stage, prefix)]
    tables = [pq.read_table(path) for path in paths if path.is_file()]
    return Answers(table=pa.concat_tables(tables)) if tables else None


def answers_on_presses(folder: Path, stage: LearningStage) -> Answers:
    """Answers of all folds on presses that they have not learned from."""
    found = read_answers(folder, stage, "press")
    if found is None:
        msg = f"'{folder}' holds no answers of the study's models"
        raise OutputError(msg)
    return found


def fits_of(stage: LearningStage, prefix: str) -> list[Fit]:
    """Fits of a stage whose names are a prefix and a number."""
    return [fit for fit in stage.fits if fit.name.rpartition("-")[0] == prefix]


def checked_parts(folder: Path, stage: LearningStage, seen: Answers) -> dict[str, Answers | None]:
    """Answers on the presses that were rendered again, as they are and in each further rendering, by its name."""
    further = {name: read_answers(folder, stage, "press", f"answers-{name}.parquet") for name, _, _ in stage.also}
    presses = [each.column("press") for each in further.values() if each is not None]
    if not presses:
        return {}
    return {"as they are": seen.where(np.isin(seen.column("press"), np.concatenate(presses))), **further}
