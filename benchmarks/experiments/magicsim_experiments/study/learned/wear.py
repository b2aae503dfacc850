"""Wear: how long a model of a new sensor holds, which drift costs what, and what a second unit takes to learn."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import numpy as np

from magicsim.errors import ConfigError
from magicsim_experiments.learn.fitting import Fit
from magicsim_experiments.learn.samples import Label
from magicsim_experiments.learn.settings import CHANNELS
from magicsim_experiments.study.learned.answers import read_answers
from magicsim_experiments.study.learned.data import share_name
from magicsim_experiments.study.learned.learned_study import (
    ERROR_COLUMNS,
    LearnedStudy,
    absolute_error,
    answer_figures,
    error_row,
    error_series,
)
from magicsim_experiments.study.learned.localisation import LABELS, read_touches, touched_frames
from magicsim_experiments.study.learned.wear_settings import WearConfig
from magicsim_experiments.study.plots import Series, plot_series
from magicsim_experiments.study.protocol import Cell, Column, Figure, Row, Stage, StudyResult, Table
from magicsim_experiments.study.stages import DatasetStage

OTHER = "other-unit"
"""Name of the data of the second unit."""
READS = dict.fromkeys(CHANNELS, "beside the present untouched frame") | {"frame": "alone"}
"""Inputs of the models, and how they read a frame."""
PLOTTED = ("p_x", "f_z")
"""Labels that are drawn."""
NOTES = (
    "Labels as in localisation: P is the indenter's tip and its depth, F its force on the sensor. Standard contacts "
    "press 1.2 mm and shear up to 1 mm, heavy ones 1.6 and 1.5 mm.",
    "What wears, and how far, is assumed; all drifts grow in proportion with the contacts. Every part of a life is "
    "filmed with the wear of its end, on contacts of its own.",
    "A frame is read beside the untouched frame of its own time, or alone: the first takes out what does not move.",
    "Exposure and white balance are metered anew in each part, as by a camera that is switched on: what dims all of a "
    "channel costs noise alone.",
    "Thinner skin and haze change the whole clear body, sides and walls included.",
)


class Wear(LearnedStudy):
    """The study `wear`."""

    settings = WearConfig
    read = read_touches
    counted = touched_frames
    needs_masks: ClassVar[bool] = True
    config: WearConfig

    def __init__(self, config: WearConfig) -> None:
        """Takes the settings, and lays out the life of one unit, each drift alone, and a second unit."""
        super().__init__(config)
        labels, count = self.data[0].recipe.labels, config.parts
        self._life = {
            k / count: DatasetStage(
                name=f"life-{k:02d}",
                recipe=config.worn_recipe(
                    config.drifts, k / count, number=k, episodes=config.part_episodes, labels=labels
                ),
            )
            for k in range(1, count + 1)
        }  # fmt: skip
        self._alone = {
            drift.name: DatasetStage(
                name=f"drift-{drift.name}",
                recipe=config.worn_recipe(
                    (drift,), 1.0, number=count + 1, episodes=config.drift_episodes, labels=labels
                ),
            )
            for drift in config.drifts
        }  # fmt: skip
        second = config.unit_recipe(1, count + 2, episodes=config.other_episodes, labels=labels)
        self._other = DatasetStage(name=OTHER, recipe=second)
        further = (each.name for each in (*self._life.values(), *self._alone.values(), self._other))
        self.learning = replace(self.learning, also={**self.learning.also, **dict.fromkeys(further, False)})
        first = self.learning.fits[0]
        self._plain = replace(
            self.learning, name="learning-frame", fits=(first,),
            settings=config.learning.model_copy(update={"input": "frame"}),
        )  # fmt: skip
        self._tuning = self.tuned(
            self._other, config.fine_tuning,
            *(Fit(name=f"{share_name(share)}-0", network=first.network, fold=0, folds=2, share=share)
              for share in sorted(config.tuned_shares)),
        )  # fmt: skip

    def refuse(self) -> None:
        """Refuses drifts of one name, and data that cannot be learned from."""
        super().refuse()
        names = [drift.name for drift in self.config.drifts]
        if len(set(names)) < len(names):
            raise ConfigError(f"drifts = {names} is not allowed: names must all differ")

    def stages(self) -> Sequence[Stage]:
        """All data, the models of the new sensor, and those of the second unit."""
        tuning = [self._tuning] if self._tuning.fits else []
        data = [*self.data, *self._life.values(), *self._alone.values(), self._other]
        return [*data, self.learning, self._plain, *tuning]

    def conclude(self, folder: Path) -> StudyResult:
        """Errors along the life, with each drift alone, and on the second unit."""
        errors, _, _, checks = self.number_tables(folder, LABELS)
        life = tuple(self._read_rows(folder, {0.0: self.data[0], **self._life}, "wear"))
        alone = tuple(self._read_rows(folder, {"nothing, new": self.data[0], **self._alone}, "drift"))
        cross = tuple(self._cross_rows(folder))
        end = max(self._life)
        headline: dict[str, Cell] = {
            f"{row['label']}_{str(row['unit']).lower()}_{'new' if row['wear'] == 0 else 'worn'}": row["error"]
            for row in life
            if row["wear"] in (0.0, end) and row["read"] == READS["difference"] and row["label"] in PLOTTED
        }
        seen = self.seen(folder)
        first = (Column(name="label"), Column(name="read"))
        last = (
            Column(name="unit"), *ERROR_COLUMNS, Column(name="constant", title="constant answer", digits=4),
            Column(name="neighbour", title="nearest neighbour", digits=4),
        )  # fmt: skip
        return StudyResult(
            headline=headline | {"frames": len(seen)},
            tables=(
                errors,
                Table(
                    name="life", title="Self-test: errors along the life of one unit",
                    columns=(*first, Column(name="wear", title="share of its life", digits=2), *last), rows=life,
                ),
                Table(
                    name="drifts", title="What each drift costs alone, at the end of a life",
                    columns=(*first, Column(name="drift"), *last), rows=alone,
                ),
                Table(
                    name="cross", title="Cross-test: a second unit, without and with fine-tuning",
                    columns=(
                        Column(name="label"), Column(name="share", title="share of its first half", digits=2),
                        Column(name="tuned_frames", title="frames learned from", digits=0), Column(name="unit"),
                        *ERROR_COLUMNS,
                    ),
                    rows=cross,
                ),
                checks,
            ),
            figures=(*_life_figures(life), *_cross_figures(cross), *answer_figures(seen, LABELS)),
            facts=self.facts(seen, "touched frames") | {"Drifts": ", ".join(each.name for each in self.config.drifts)},
            notes=NOTES,
        )  # fmt: skip

    def _read_rows(
        self, folder: Path, parts: Mapping[float, DatasetStage] | Mapping[str, DatasetStage], what: str
    ) -> Iterator[Row]:
        """A row a label, way of reading and set of frames; of the first data unseen presses."""
        seed = self.config.seed
        for label in LABELS:
            for stage in (self.learning, self._plain):
                for key, data in parts.items():
                    found = self.first_model(folder, stage, data.name)
                    if found is None or not len(found):
                        continue
                    others = {
                        method: absolute_error(found, method, label, seed=seed).value
                        for method in ("constant", "neighbour")
                    }
                    first = {"read": READS[stage.settings.input], what: key}
                    yield {**error_row(first, label, absolute_error(found, "model", label, seed=seed)), **others}

    def _cross_rows(self, folder: Path) -> Iterator[Row]:
        """A row a label and share of the second unit's first half, on the other half."""
        seed = self.config.seed
        shares = sorted(self.config.tuned_shares)
        tuned = {share: read_answers(folder, self._tuning, share_name(share)) for share in shares}
        kept = next((each.column("press") for each in tuned.values() if each is not None), None)
        plain = self.first_model(folder, self.learning, self._other.name)
        if plain is not None and kept is not None:
            plain = plain.where(np.isin(plain.column("press"), kept))
        for label in LABELS:
            for share, found in ({0.0: plain} | tuned).items():
                if found is None or not len(found):
                    continue
                frames = int(found.column("train_frames")[0]) if share else 0
                first: dict[str, Cell] = {"share": share, "tuned_frames": frames}
                yield error_row(first, label, absolute_error(found, "model", label, seed=seed))


def _life_figures(rows: Sequence[Row]) -> Iterator[Figure]:
    for label in _plotted(rows):
        own = [row for row in rows if row["label"] == label.name]
        series = [
            error_series(f"read {read}", [row for row in own if row["read"] == read], "wear")
            for read in dict.fromkeys(str(row["read"]) for row in own)
        ]
        series.append(Series(name="constant answer", x=[], y=[float(str(own[0]["constant"]))], is_level=True))
        yield _figure("life", "Self-test", label, series, "share of its life", "along the life of a sensor")


def _cross_figures(rows: Sequence[Row]) -> Iterator[Figure]:
    for label in _plotted(rows):
        series = [error_series("second unit", [row for row in rows if row["label"] == label.name], "tuned_frames")]
        x_title = "frames of it learned from"
        yield _figure("cross", "Cross-test", label, series, x_title, "against frames of the second unit")


def _figure(kind: str, test: str, label: Label, series: Sequence[Series], x_title: str, against: str) -> Figure:
    title, name = f"error of {label.name} [{label.unit}]", f"{kind}-{label.name.replace('_', '-')}"
    svg = plot_series(series, x_title=x_title, y_title=title, name=name, label=f"{title} {against}")
    return Figure(name=f"{kind}-{label.name}", title=f"{test}: {title}", svg=svg)


def _plotted(rows: Sequence[Row]) -> list[Label]:
    there = {row["label"] for row in rows}
    return [label for label in LABELS if label.name in PLOTTED and label.name in there]
