"""Where an indenter touches and with what force: P and F from a frame, in normal presses and under shear."""

from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar, Literal

import numpy as np
import numpy.typing as npt

from magicsim.dataset.recipes.entries import PathRecipe, TouchPath
from magicsim.errors import ConfigError
from magicsim_experiments.learn.baselines import change_features
from magicsim_experiments.learn.samples import Chosen, EpisodeRows, Label, Samples, read_samples
from magicsim_experiments.learn.settings import LearningSettings
from magicsim_experiments.study.learned.data import LearnedConfig
from magicsim_experiments.study.learned.learned_study import LearnedStudy, answer_figures, compared_table, curve_figures
from magicsim_experiments.study.protocol import StudyResult

LABELS = (
    Label(name="p_x", unit="mm"), Label(name="p_y", unit="mm"), Label(name="p_z", unit="mm"),
    Label(name="f_x", unit="N"), Label(name="f_y", unit="N"), Label(name="f_z", unit="N"),
)  # fmt: skip
"""Place of the indenter's tip on the face and its depth; force of the indenter on the sensor."""
NORMAL, SHEARED = 0, 1
"""Groups of frames."""
GROUPS = {"normal press": NORMAL, "shear": SHEARED}
SHEAR_MM = 1e-6
"""Slide along the face from which a frame counts as sheared [mm]."""
NOTES = (
    "P is the place of the indenter's tip (x, y) and its depth below the untouched face (z); F is the force of the "
    "indenter on the sensor, as the solver knows it.",
    "The linear fit takes centroid and spread of the change by channel, and the true contact area as the camera would "
    "see it: the geometric answer of somebody who segments the contact without an error.",
    "Intervals draw whole presses again; frames of a press are never in two parts.",
    "Against the protocol: one indenter, one press and one shear for each depth, and depths drawn evenly instead of in "
    "four levels.",
)


class LocalisationConfig(LearnedConfig):
    """Settings of the study."""

    kind: Literal["localisation"]


def touched_frames(paths: Sequence[PathRecipe]) -> int:
    """Most frames of an episode that touch."""
    touches = [path for path in paths if isinstance(path, TouchPath)]
    return max(
        (path.press_frames + path.shear_frames + path.twist_frames + path.hold_frames for path in touches), default=0
    )


def read_touches(folder: Path, settings: LearningSettings) -> Samples:
    """Touched frames of a dataset."""
    return read_samples(
        folder, LABELS, _touched, columns=("contact", "object_position_mm", "depth_mm", "force_n"),
        long_side_px=settings.long_side_px, masks=True,
    )  # fmt: skip


class Localisation(LearnedStudy):
    """The study `localisation`."""

    settings = LocalisationConfig
    read = read_touches
    counted = touched_frames
    needs_masks: ClassVar[bool] = True

    def refuse(self) -> None:
        """Refuses a recipe without presses or with too few."""
        super().refuse()
        if not touched_frames(self.data[0].recipe.paths):
            raise ConfigError("recipe.paths has no touch: study 'localisation' needs one")

    def conclude(self, folder: Path) -> StudyResult:
        """Errors by label and method, on unseen presses and units, normal and sheared, and what they rest on."""
        seen, seed = self.seen(folder), self.config.seed
        errors, units, curve, checks = self.number_tables(folder, LABELS)
        shear = compared_table(
            {name: seen.where(seen.column("group") == group) for name, group in GROUPS.items()}, LABELS,
            name="shear", title="With and without shear", seed=seed,
        )  # fmt: skip
        return StudyResult(
            headline=self.headline(seen, LABELS) | {"presses": len(np.unique(seen.column("press")))},
            tables=(errors, shear, units, curve, *self.beyond(folder, LABELS), checks),
            figures=(*curve_figures(curve, errors, LABELS), *answer_figures(seen, LABELS)),
            facts=self.facts(seen, "touched frames"),
            notes=NOTES,
        )


def _touched(episode: EpisodeRows) -> Chosen:
    rows = np.array(episode.columns["contact"], bool)
    places = episode.vectors("object_position_mm", 3)[:, :2]
    depth, forces = (np.array(episode.columns[name], float) for name in ("depth_mm", "force_n"))
    slid = np.linalg.norm(places - places[rows][0], axis=1) if rows.any() else np.zeros(len(rows))
    masks = np.stack([mask_features(mask) for mask in episode.masks])
    return Chosen(
        rows=rows,
        targets=np.column_stack([places, depth, forces]),
        features=np.column_stack([change_features(episode.images, episode.untouched), masks]),
        group=np.where(slid > SHEAR_MM, SHEARED, NORMAL),
    )


def mask_features(mask: npt.NDArray[np.bool_]) -> npt.NDArray[np.float64]:
    """Centroid of a contact mask in shares of the image, its area's share and its radius; shape (4,), zeros of none."""
    area = float(mask.mean())
    if area == 0:
        return np.zeros(4)
    rows, columns = np.nonzero(mask)
    return np.array([rows.mean() / mask.shape[0], columns.mean() / mask.shape[1], area, np.sqrt(area)])
