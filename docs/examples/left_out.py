"""What a scene does not need: how many frames of the demo are solved and rendered at all.

python docs/examples/left_out.py           # three numbers, at once
"""

from magicsim import load_scene, plan_scene


def counts(scene: str) -> tuple[int, int, int]:
    """Scored frames of a scene, how many of them are solved, and how many are rendered."""
    frames = plan_scene(load_scene(scene)).frames
    return len(frames), sum(frame.solve for frame in frames), sum(frame.same_as is None for frame in frames)


if __name__ == "__main__":
    print("{} frames, {} solved, {} rendered".format(*counts("demo")))
