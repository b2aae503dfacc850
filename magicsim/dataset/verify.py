"""Checks a dataset's folder against its manifest: every hash, every row, every image."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from magicsim.config.named_files import named_files
from magicsim.config.program import SOURCES
from magicsim.dataset.assembly import Layout
from magicsim.dataset.manifest import CONFIG, FOLDER, MANIFEST, PREVIEW_FILES, Manifest, ShardEntry, known_manifest
from magicsim.dataset.preview import changed_preview
from magicsim.dataset.recipes.recipe import Recipe, load_recipe
from magicsim.dataset.shard import decoded_png
from magicsim.deform.quality import SOLVE_QUALITIES
from magicsim.errors import MagicsimError
from magicsim.folder.ledger import WORK
from magicsim.folder.listing import files_below, sha256_of
from magicsim.folder.target import is_lock
from magicsim.workers.run_folder import ERRORS, changed_lines

MADE_BY = ("config_hash", "version", "variant")
"""Columns that say what made a row."""
TAXEL_ROUNDING = 1e-9
"""Largest difference of the sum over all taxels from force and torque, as a share and in N and N mm."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Verification:
    """What `magicsim dataset verify` reports."""

    samples: int
    """Rows in shards that are whole."""
    shards: int
    failed: int
    """Episodes without rows, as the manifest lists them."""
    complete: bool
    """Whether the dataset holds all that its recipe asks for."""
    made_by: str
    """Versions and the digest of the sources that made it."""
    problems: list[str]
    """One line for each; empty where the dataset is as it was written."""


def verify_dataset(folder: Path) -> Verification:
    """Reads everything; `OutputError` where the folder holds no dataset."""
    manifest = known_manifest(folder)
    try:
        recipe = load_recipe(folder / CONFIG)
    except MagicsimError:
        recipe = None  # frames were recorded, or `_files` tells that it has changed
    problems = [*_itself(folder, manifest, recipe), *_files(folder, manifest), *_strangers(folder, manifest)]
    problems += [f"{ERRORS}: line {number} has changed since it was written" for number in changed_lines(folder)]
    problems += [f"{name}: changed since it was written" for name in changed_preview(folder)]
    balance = SOLVE_QUALITIES[recipe.contact.quality if recipe is not None else "full"].newton.largest_balance
    samples = 0
    for entry in manifest.shards:
        wrong = list(_shard(folder, entry, manifest, balance))
        samples += entry.rows if not wrong else 0
        problems += wrong
    return Verification(
        samples=samples,
        shards=len(manifest.shards),
        failed=len(manifest.failed),
        complete=manifest.is_complete,
        made_by=manifest.constants()["version"] if SOURCES in manifest.versions else "unknown code",
        problems=problems,
    )


def _itself(folder: Path, manifest: Manifest, recipe: Recipe | None) -> Iterator[str]:
    """What the manifest says wrongly of itself and of the recipe."""
    if not FOLDER.is_unchanged(folder):
        yield f"{MANIFEST}: changed since it was written (its own SHA-256 differs)"
    if sum(entry.rows for entry in manifest.shards) != manifest.rows:
        yield f"{MANIFEST}: rows = {manifest.rows} is not the sum over its shards"
    if recipe is None:
        return
    named = named_files(recipe.model_dump(mode="json"))  # which may be elsewhere, or others by now
    for name, listed, wanted in (
        ("config_hash", manifest.config_hash, manifest.config_hash if named else recipe.config_hash()),
        ("seed", manifest.seed, recipe.seed),
        ("episodes", manifest.episodes, recipe.episodes),
    ):
        if listed != wanted:
            yield f"{MANIFEST}: {name} = {listed} is not that of {CONFIG}, {wanted}"
    yield from _plan(recipe, manifest)


def _plan(recipe: Recipe, manifest: Manifest) -> Iterator[str]:
    """Where the manifest's shards differ from those that the recipe gives."""
    failed = {each.episode for each in manifest.failed}
    layout = Layout(recipe)
    held = [episode for entry in manifest.shards for episode in entry.episodes]
    for entry in manifest.shards:
        known = [layout[layout.number_of(each)] for each in entry.episodes[:1] if 0 <= each < recipe.episodes]
        if not any(
            (entry.file, entry.split) == (plan.file, plan.split) and set(entry.episodes) <= set(plan.episodes)
            for plan in known
        ):
            yield f"{MANIFEST}: {entry.file} is no shard of the recipe's, with split '{entry.split}' and its episodes"
    everything = len(set(held) | failed) == manifest.episodes
    if manifest.is_complete != everything or len(held) != len(set(held)) or failed & set(held):
        state = "complete" if manifest.is_complete else "not complete"
        yield f"{MANIFEST}: says that the dataset is {state}, unlike its episodes"


def _files(folder: Path, manifest: Manifest) -> Iterator[str]:
    for name, digest in manifest.files.items():
        if not (folder / name).is_file():
            yield f"{name}: missing"
        elif sha256_of(folder / name) != digest:
            yield f"{name}: changed since it was written (SHA-256 differs)"


def _strangers(folder: Path, manifest: Manifest) -> Iterator[str]:
    """Every file that the manifest does not list; an unfinished dataset has some that it will."""
    known = {MANIFEST, ERRORS, *PREVIEW_FILES, *manifest.listed()}
    for name in files_below(folder):
        if name in known or is_lock(name) or (name.startswith(f"{WORK}/") and not manifest.is_complete):
            continue
        yield f"{name}: not in the manifest" + ("" if manifest.is_complete else " yet; --resume finishes it")


def _shard(folder: Path, entry: ShardEntry, manifest: Manifest, balance: float) -> Iterator[str]:
    """Problems of a shard; `balance` is the largest relative difference of contact force and reaction."""
    path = folder / entry.file
    if not path.is_file():
        yield f"{entry.file}: missing"
        return
    if path.stat().st_size != entry.size or sha256_of(path) != entry.sha256:
        yield f"{entry.file}: changed since it was written (SHA-256 differs)"
        return
    try:
        with pq.ParquetFile(path) as file:
            yield from (f"{entry.file}: {problem}" for problem in _rows(file, entry, manifest, balance))
    except (pa.ArrowException, OSError, KeyError) as error:
        yield f"{entry.file}: cannot be read: {' '.join(str(error).split())}"


def _rows(file: pq.ParquetFile, entry: ShardEntry, manifest: Manifest, balance: float) -> Iterator[str]:
    plain = ["episode", "step", *MADE_BY, "contact", "force_n", "force_balance"]
    table = file.read(columns=[name for name in plain if name in file.schema_arrow.names])
    episodes = table["episode"].to_pylist()
    if tuple(sorted(set(episodes))) != entry.episodes or table.num_rows != entry.rows:
        yield f"holds {table.num_rows} rows of episodes {sorted(set(episodes))}, not what the manifest lists"
    if set(table["config_hash"].to_pylist()) - {manifest.config_hash}:
        yield "holds rows of another recipe"
    made_by = manifest.constants() | {"variant": manifest.variant}
    for name in sorted({"version", "variant"} & set(table.column_names)):
        for other in sorted(set(table[name].to_pylist()) - {made_by[name]}):
            differing = ", ".join(sorted(set(other.split(", ")) - set(made_by[name].split(", "))))
            yield f"holds rows that other code made than the manifest says: {name} {differing or other}"
    if {"force_n", "force_balance"} <= set(table.column_names):  # of simulated rows
        force = np.array(table["force_n"].to_pylist())
        if not np.isfinite(force).all() or (np.array(table["force_balance"]) > balance).any():
            yield "holds rows whose force is not finite or not balanced"
        if ((np.linalg.norm(force, axis=1) > 0) != np.array(table["contact"])).any():
            yield "holds rows whose contact flag contradicts their force"
    yield from _taxels(file)
    for number in range(file.num_row_groups):
        for name in ("image", "contact_mask"):
            if name in file.schema_arrow.names:
                images = file.read_row_group(number, columns=[name])[name].to_pylist()
                if any(each is None or decoded_png(each["bytes"]) is None for each in images):
                    yield f"{name}: a PNG of row group {number} cannot be decoded"


def _taxels(file: pq.ParquetFile) -> Iterator[str]:
    """Where forces or torques of the taxels do not add up to those of the object."""
    for taxels, whole in (("taxel_force_n", "force_n"), ("taxel_torque_nmm", "torque_nmm")):
        if taxels not in file.schema_arrow.names:
            continue
        table = file.read(columns=[taxels, whole])
        total = np.array([np.sum(each, axis=0) for each in table[taxels].to_pylist()])
        expected = np.array(table[whole].to_pylist())
        if not np.allclose(total, expected, rtol=TAXEL_ROUNDING, atol=TAXEL_ROUNDING):
            yield f"holds rows whose {taxels} does not add up to {whole}"
