import base64
import re
from dataclasses import replace

import cv2
import numpy as np

from magicsim.detectors.combined import judge
from magicsim.detectors.profile import load_profile
from magicsim.live.sight import frame_picture, state_line, verdict_table
from magicsim.notebook.screen import change, on_screen


def test_table_has_a_column_for_each_profile_and_says_why_one_gives_no_verdict():
    verdict = judge(entropy=3.25, correlation=0.1, similarity=0.9, profile=load_profile("published"))
    table = verdict_table({"published": verdict, "calibrated": "no <grid> here"})
    assert "3.250" in table
    assert str(verdict.proximity) in table
    assert "no &lt;grid&gt; here" in table
    assert verdict_table({}) == verdict_table({})
    assert replace(verdict, entropy=1.0) != verdict


def test_what_is_written_is_escaped():
    line = state_line(("solving", 3.2), "<script>alert(1)</script>")
    assert "<script>" not in line
    assert "solving, 3 s" in line
    assert state_line(None, None).count("ready") == 1


def test_frame_and_its_change_arrive_without_loss():
    frame, rest = np.random.default_rng(1).integers(0, 256, (2, 32, 24, 3), np.uint8)
    data = re.search(r"base64,([^']+)'", frame_picture(frame, rest, gamma=1.0))
    assert data is not None
    back = cv2.imdecode(np.frombuffer(base64.b64decode(data[1]), np.uint8), cv2.IMREAD_COLOR_RGB)
    assert (back[:, :24] == on_screen(frame, gamma=1.0)).all()
    assert (back[:, -24:] == change(frame, rest)).all()
