"""MCAP: a folder a split, one file an episode (foxglove-sdk)."""

from pathlib import Path

from magicsim.dataset.export.mcap_episode import write_mcap_episode
from magicsim.dataset.export.source import Source


def write_mcap(source: Source, folder: Path) -> None:
    """Writes `<split>/episode-NNNNNNNN.mcap`."""
    window = source.recipe.rig.camera.window
    for split in source.splits:
        (folder / split).mkdir()
        for shard in source.shards(split):
            for number, table in zip(shard.episodes, source.episodes(shard), strict=True):
                write_mcap_episode(
                    folder / split / f"episode-{number:08d}.mcap",
                    table.to_pylist(),
                    size=(window.columns, window.rows),
                    about={"episode": str(number), "config_hash": source.manifest.config_hash},
                )
