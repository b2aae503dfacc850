import threading

from magicsim.live.worker import Mailbox


def test_newest_request_wins_and_the_others_are_counted():
    box: Mailbox[int] = Mailbox()
    for number in range(5):
        box.put(number)
    assert box.is_waiting
    assert box.take() == 4
    assert not box.is_waiting
    assert box.replaced == 4


def test_nothing_in_time_is_none():
    assert Mailbox[int]().take(timeout_s=0.01) is None


def test_closing_lets_a_waiting_thread_go():
    box: Mailbox[int] = Mailbox()
    taken: list[int | None] = []
    waiting = threading.Thread(target=lambda: taken.append(box.take()))
    waiting.start()
    box.close()
    waiting.join(5)
    assert taken == [None]
    assert box.is_closed
