import numpy as np
import pytest

from magicsim.detectors.profile import load_profile
from magicsim.errors import ConfigError
from magicsim_experiments.study.fusion import FusionTask, episode_scene, judged
from magicsim_experiments.study.study_file import load_study


def test_more_references_quiet_the_rest_and_drift_alarms_late():
    random = np.random.default_rng(0)
    base = random.uniform(20, 60, (40, 30, 3))

    def frames(count: int, shift: float = 0.0) -> list[np.ndarray]:
        return [np.clip(np.rint(base + shift + random.normal(0, 1, base.shape)), 0, 255).astype(np.uint8)
                for _ in range(count)]  # fmt: skip

    profile, references = load_profile("published"), frames(30)
    still = {n: judged(references[-n:], frames(9), frames(9), frames(9, 9.0), frames(3, 25.0), profile, n=n, m=1)
             for n in (1, 30)}  # fmt: skip
    assert still[30]["rest_entropy"] < still[1]["rest_entropy"]  # noise of sqrt(1 + 1 / N)
    assert still[30]["approach_area"] == still[30]["touch_area"] == 1.0
    many = judged(references, frames(9), frames(9), frames(9, 9.0), frames(3, 25.0), profile, n=30, m=10)
    assert many["rest_entropy"] < still[30]["rest_entropy"]  # the largest of ten means
    drifted = judged(references, frames(9), frames(9, 9.0), frames(9, 9.0), frames(3, 25.0), profile, n=30, m=1)
    assert abs(drifted["approach_area"] - 0.5) < 0.25
    assert drifted["late_alarms"] == 1.0


def test_episode_has_references_rest_wait_and_object():
    study = load_study("fusion", ["wait_s=2.0", "references=[1,5]"], quick=True)
    scene = episode_scene(FusionTask(config=study.config, light=study.config.lights[1], repeat=0))
    assert (scene.references, scene.keyframes[1].frame, scene.frame_count) == (5, 90, 101)
    assert scene.rig.camera.led_drift.share == 0.005
    assert scene.rig.camera.columns == study.config.rig.camera.columns // 2


def test_coat_and_unknown_light_are_refused():
    with pytest.raises(ConfigError, match=r"design\.coat is opaque"):
        load_study("fusion", design="gelsight-type")
    with pytest.raises(ConfigError, match=r"light 'odd': unknown key in .*'glow'"):
        load_study("fusion", ["lights=[{name='odd',camera={glow={share=1}}}]"])
