"""What simulating a scene will take, told or refused before any work."""

import os

from magicsim.dataset.recipes.estimate import estimate_scene, lattice_nodes, taxel_bytes
from magicsim.errors import ConfigError
from magicsim.scenes.scene import SceneConfig
from magicsim.workers.attempt import usable_cores

LONG_S = 300.0
"""Time from which an estimate is worth a line [s]."""
IMAGE_BYTES, MASK_BYTES, DEPTH_BYTES, NODE_BYTES = 3, 1, 4, 12
"""A pixel of a frame, of a mask, of a depth map; a lattice node's displacement; in memory."""


def check_memory(scene: SceneConfig) -> None:
    """Refuses (`ConfigError`) an episode whose frames and labels, kept until it is written, do not fit into memory."""
    needed, there = episode_bytes(scene), memory_bytes()
    if there is not None and needed > there:
        camera, frames = scene.rig.camera, scene.references + scene.frame_count
        raise ConfigError(
            f"{frames} frames of {camera.columns} x {camera.rows} pixels with their labels take about "
            f"{needed / 1e9:.0f} GB of memory, and there are {there / 1e9:.0f} GB: make several episodes, or leave out "
            "output.displacements, output.contact_mask, output.depth_map or output.taxels"
        )


def memory_bytes() -> int | None:
    """Memory of this machine [bytes]; None where the system does not tell, as Windows does not."""
    if not hasattr(os, "sysconf"):
        return None
    return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def episode_bytes(scene: SceneConfig) -> int:
    """Bytes of all frames and labels of an episode, about."""
    window, output = scene.rig.camera.window, scene.output
    pixel = IMAGE_BYTES + MASK_BYTES * output.contact_mask + DEPTH_BYTES * output.depth_map
    nodes = NODE_BYTES * lattice_nodes(scene) if output.displacements else 0
    frame = window.columns * window.rows * pixel + nodes + taxel_bytes(scene)
    return round((scene.references + scene.frame_count) * frame)


def long_work(scene: SceneConfig) -> str | None:
    """A line about a scene that takes long; None about others."""
    found, cores = estimate_scene(scene), usable_cores()
    if found.seconds(cores) < LONG_S:
        return None
    return (
        f"about {found.frames} frames to simulate, {found.seconds(cores) / 60:.0f} minutes on {cores} cores and "
        f"{found.bytes / 1e6:.0f} MB (rough estimates)"
    )
