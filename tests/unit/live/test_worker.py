"""Newest request wins, and nobody waits for the worker."""

import threading
import time
from dataclasses import dataclass, field

import pytest

from magicsim.errors import ConfigError
from magicsim.live.session import Worker


@dataclass
class Slow:
    """A session whose every wish takes until it is let go."""

    gate: threading.Event = field(default_factory=threading.Event)
    done: list[str] = field(default_factory=list)
    pause_s: float | None = None
    now: str = "as it is"

    def go(self, wish: str) -> str:
        assert self.gate.wait(10)
        if wish == "wrong":
            msg = "wrong is not allowed"
            raise ConfigError(msg)
        self.done.append(wish)
        return wish

    def look(self, sight: str) -> str:
        return f"{sight} seen"


@pytest.fixture
def session() -> Slow:
    return Slow()


def test_wishes_that_come_meanwhile_are_dropped_for_the_newest(session: Slow, until):
    shown: list[str] = []
    worker = Worker(session, shown.append, shown.append)  # type: ignore[arg-type]
    worker.start()
    worker.ask("first")  # type: ignore[arg-type]
    until(lambda: worker.busy is not None)
    before = time.monotonic()
    for wish in ("second", "third", "last"):
        worker.ask(wish)  # type: ignore[arg-type]
    assert time.monotonic() - before < 1
    assert worker.is_asked
    session.gate.set()
    until(lambda: "last seen" in shown)
    assert session.done == ["first", "last"]
    assert shown == ["first", "first seen", "last", "last seen"]
    worker.stop()


def test_what_passes_in_the_room_is_shown_again_without_a_wish(session: Slow, until):
    shown: list[str] = []
    session.pause_s = 0.01
    worker = Worker(session, shown.append, shown.append)  # type: ignore[arg-type]
    session.gate.set()
    worker.start()
    time.sleep(0.05)
    assert shown == []  # nothing before the first wish
    worker.ask("first")  # type: ignore[arg-type]
    until(lambda: shown.count("as it is seen") > 1)
    assert shown[:2] == ["first", "first seen"]
    worker.ask("wrong")  # type: ignore[arg-type]
    until(lambda: "wrong is not allowed" in shown)
    worker.stop()
    assert shown[-1] == "wrong is not allowed"  # a session that failed is not asked again and again


def test_stopping_lets_a_worker_go_that_waits_for_a_wish(session: Slow):
    worker = Worker(session, print, print)  # type: ignore[arg-type]
    worker.start()
    before = time.monotonic()
    worker.stop()
    assert time.monotonic() - before < 5


def test_worker_survives_an_error_and_tells_it(session: Slow, until):
    shown: list[str] = []
    worker = Worker(session, shown.append, shown.append)  # type: ignore[arg-type]
    session.gate.set()
    worker.start()
    worker.ask("wrong")  # type: ignore[arg-type]
    until(lambda: shown == ["wrong is not allowed"])
    worker.ask("right")  # type: ignore[arg-type]
    until(lambda: "right seen" in shown)
    until(lambda: worker.busy is None)
    worker.stop()
    worker.stop()
