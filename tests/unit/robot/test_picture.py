import base64
import re
import sys
import urllib.request

import cv2
import numpy as np
import pytest

from magicsim.robot.picture import Picture


def test_without_a_screen_the_frame_is_on_a_local_page(monkeypatch: pytest.MonkeyPatch, capsys):
    monkeypatch.setitem(sys.modules, "tkinter", None)  # as where it is missing
    frame = np.random.default_rng(3).integers(0, 256, (8, 6, 3), np.uint8)
    picture = Picture("a sensor")
    try:
        picture.show(frame)
        assert picture.address is not None
        assert picture.address.startswith("http://127.0.0.1:")
        assert picture.address in capsys.readouterr().err
        with urllib.request.urlopen(picture.address, timeout=10) as answer:
            found = re.search(rb"base64,([^']+)'", answer.read())
        assert found is not None
        shown = cv2.imdecode(np.frombuffer(base64.b64decode(found[1]), np.uint8), cv2.IMREAD_COLOR_RGB)
        assert (shown == frame).all()
    finally:
        picture.close()
