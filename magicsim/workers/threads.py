"""How many threads the renderer of a worker process may use."""


def bound_threads(threads: int) -> None:
    """Tells the renderer of this process how many threads it may use; frames do not depend on it."""
    from magicsim.light.backend import dr

    dr.set_thread_count(threads)
