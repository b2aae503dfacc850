"""A stage that writes a dataset from a recipe, in a folder of its own below the study's."""

import time
from dataclasses import dataclass
from pathlib import Path

from magicsim.dataset.generate import Simulator, Standing, generate_dataset
from magicsim.dataset.manifest import FailedEpisode, Manifest, read_manifest
from magicsim.dataset.recipes.draw import draw_episodes
from magicsim.dataset.recipes.estimate import estimate
from magicsim.dataset.recipes.recipe import Recipe
from magicsim.errors import OutputError
from magicsim.folder.lock import LOCK
from magicsim_experiments.study.protocol import DATA, Workshop


@dataclass(frozen=True, slots=True, kw_only=True)
class DatasetStage:
    """Writes one dataset."""

    name: str
    recipe: Recipe
    simulator: Simulator | None = None
    """What makes rows, where it is not the simulation."""

    def folder(self, study: Path) -> Path:
        """Folder of the dataset below that of a study."""
        return dataset_folder(study, self.name)

    def core_seconds(self, processes: int) -> float:
        """Rough time on one core [s]."""
        return estimate(self.recipe, draw_episodes(self.recipe), processes=processes).core_seconds

    def is_done(self, folder: Path) -> bool:
        """Whether the dataset is whole and of this recipe; episodes without a valid answer do not count."""
        manifest = read_manifest(self.folder(folder))
        return (
            manifest is not None
            and manifest.is_complete
            and manifest.config_hash == self.recipe.config_hash()
            and bool(manifest.shards)
            and not _lost(manifest)
        )

    def owns(self, name: str) -> bool:
        """Whether a file is in the dataset's folder, or its lock."""
        place = f"{DATA}/{self.name}"
        path = Path(place)
        return name.startswith(f"{place}/") or name == (path.parent / f".{path.name}.{LOCK}").as_posix()

    def run(self, workshop: Workshop) -> None:
        """Simulates what is left.

        Raises:
            OutputError: The folder holds a dataset of another recipe, no episode has rows, or some failed for a reason
                that may pass.
        """
        start = time.monotonic()

        def tell(standing: Standing) -> None:
            failed = f", {standing.failed} failed" if standing.failed else ""
            rate = standing.frames / max(time.monotonic() - start, 1e-6)
            workshop.tell(standing.done / standing.total, f"{self.name}: {rate:.2f} frames/s{failed}")

        found = generate_dataset(
            self.recipe, self.folder(workshop.folder), options=workshop.options, resume=True,
            simulator=self.simulator, progress=tell,
        )  # fmt: skip
        manifest = read_manifest(self.folder(workshop.folder))
        lost = _lost(manifest) if manifest is not None else []
        if lost:
            msg = f"{len(lost)} episodes of '{self.name}' have no frames ({lost[0].message}); --resume tries them again"
            raise OutputError(msg)
        if not found.samples:
            msg = f"no episode of '{self.name}' has frames: see its errors.jsonl"
            raise OutputError(msg)


def _lost(manifest: Manifest) -> list[FailedEpisode]:
    """Episodes that failed for a reason that may pass."""
    return [each for each in manifest.failed if each.kind != "refused"]


def dataset_folder(study: Path, name: str) -> Path:
    """Folder of one of a study's datasets."""
    return study / DATA / name
