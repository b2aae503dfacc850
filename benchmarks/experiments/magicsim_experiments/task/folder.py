"""The folder that a run of grasps grows in: a file an episode, whole or not there, and what they belong to."""

from magicsim.workers.run_folder import RunFolder, RunIndex

INDEX, RESULTS, EPISODES = "task.json", "results.json", "episodes"
FRAMES_TABLE, EPISODES_TABLE = "frames.parquet", "episodes.parquet"


class TaskIndex(RunIndex):
    """What a folder's episodes belong to."""

    task: str = "grasp"
    episodes: int


FOLDER = RunFolder(
    index=INDEX, model=TaskIndex, noun="task", content="run of a task",
    title="Settings of a task of magicsim, everything in place",
)  # fmt: skip


def episode_name(episode: int) -> str:
    """Name of an episode's file below the folder."""
    return f"{EPISODES}/{episode:05d}.json"
