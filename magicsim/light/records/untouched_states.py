"""The last few untouched sensors, kept so that the episodes of one sensor render it once."""

from collections import OrderedDict
from functools import cache

from magicsim.light.records.untouched import Untouched
from magicsim.light.records.untouched_store import UntouchedStore, default_store

KEPT = 2
"""Sensors that are kept at most."""


class UntouchedStates:
    """The last few sensors of this process, and those on disk; their content depends on their key alone."""

    def __init__(self, store: UntouchedStore | None = None) -> None:
        """Holds nothing.

        Args:
            store: Where careful states are kept on disk, if they are.
        """
        self._states: OrderedDict[str, Untouched] = OrderedDict()
        self._store = store

    def get(self, key: str, *, on_disk: bool = False) -> Untouched | None:
        """The state of a key, if it is kept; also on disk where that is asked for."""
        if key not in self._states and on_disk and self._store is not None:
            stored = self._store.load(key)
            if stored is not None:
                self.keep(key, stored)
        if key in self._states:
            self._states.move_to_end(key)
        return self._states.get(key)

    def keep(self, key: str, state: Untouched, *, on_disk: bool = False) -> None:
        """Keeps a state, and lets the one go that was not asked for the longest."""
        if on_disk and self._store is not None:
            self._store.save(key, state)
        self._states[key] = state
        while len(self._states) > 2 * KEPT:
            self._states.popitem(last=False)


@cache
def shared_states() -> UntouchedStates:
    """Those of this process: episodes of one sensor render it once."""
    return UntouchedStates(default_store())
