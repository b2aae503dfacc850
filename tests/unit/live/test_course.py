import numpy as np

from magicsim.live.controls import KEPT, Course


def test_empty_course_can_be_drawn():
    assert all(len(column) == 2 for column in Course().columns())


def test_course_keeps_the_last_steps_and_their_numbers():
    course = Course()
    for number in range(KEPT + 5):
        course.add((3.0, 4.0, float(number)))
    steps, normal, tangential = course.columns()
    assert len(steps) == KEPT
    assert (steps == normal).all()
    assert steps[-1] == KEPT + 4
    assert np.allclose(tangential, 5.0)
