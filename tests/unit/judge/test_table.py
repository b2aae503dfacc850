import math
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from magicsim.deform.lattice.structure import box_lattice
from magicsim.detectors.combined import judge
from magicsim.detectors.profile import DetectorProfile
from magicsim.detectors.verdict import NUMBERS, WORDS
from magicsim.frame_class import FrameClass
from magicsim.judge.score import score_verdicts
from magicsim.judge.verdicts import Judgement, write_table
from magicsim.scenes.scene import load_scene
from magicsim.scenes.timeline import UNTOUCHED, FrameState, Origin
from magicsim.simulation.episode import Episode, FrameLabels, FrameTruth, SimulatedFrame, SolveFigures, frame_file
from magicsim.simulation.main_job import write_places

PRESSED = FrameState(gap_mm=-1.2, x_mm=0.5, y_mm=-0.25, twist_deg=10.0, flashlight=False, light_x_mm=0.0)
MASK = np.zeros((16, 12), bool)
MASK[2:5, 7:11] = True
MOVED = np.arange(24, dtype=np.float32).reshape(8, 3) / 7


def frame(index: int, state: FrameState, *, mask: np.ndarray | None, moved: np.ndarray | None) -> SimulatedFrame:
    pressed = state.gap_mm is not None
    return SimulatedFrame(
        image=np.full((16, 12, 3), 50, np.uint8),
        truth=FrameTruth(
            index=index,
            time_s=index / 15,
            is_reference=index < 2,
            state=state,
            contact=pressed,
            depth_mm=1.2 if pressed else 0.0,
            force_n=(0.1, 0.2, 3.0) if pressed else (0.0, 0.0, 0.0),
            torque_nmm=(-1.0, 2.0, 0.5) if pressed else (0.0, 0.0, 0.0),
            contact_area_mm2=7.5 if pressed else 0.0,
            frame_class=None if index < 2 else FrameClass.CONTACT if pressed else FrameClass.CLEAR,
            solve=SolveFigures(iterations=9, min_jacobian=0.8, max_penetration_mm=1e-3, force_balance=1e-9),
        ),
        labels=FrameLabels(contact_mask=mask, displacements_mm=moved),
    )


@pytest.fixture
def episode() -> Episode:
    states = [UNTOUCHED, UNTOUCHED, UNTOUCHED, PRESSED]
    return Episode(
        scene=load_scene("near"),
        frames=tuple(frame(k, state, mask=MASK, moved=MOVED) for k, state in enumerate(states)),
    )


@pytest.fixture
def judgement(episode: Episode) -> Judgement:
    profile = DetectorProfile()
    verdicts = tuple(
        judge(entropy=entropy, correlation=0.1, similarity=similarity, profile=profile)
        for entropy, similarity in ((0.1, 0.9), (2.0, 0.3))
    )
    score = score_verdicts(verdicts, [each.truth.frame_class for each in episode.scored])
    return Judgement(profile="published", thresholds={}, verdicts=verdicts, score=score)


def written(path: Path, episode: Episode, *judgements: Judgement) -> pa.Table:
    write_table(path / "episode.parquet", episode, judgements)
    return pq.read_table(path / "episode.parquet")


def test_there_is_one_row_a_frame_references_included(tmp_path: Path, episode: Episode):
    table = written(tmp_path, episode)
    assert table["step"].to_pylist() == [0, 1, 2, 3]
    assert table["is_reference"].to_pylist() == [True, True, False, False]
    assert table["file"].to_pylist()[3] == frame_file(3) == "frames/00003.png"
    assert table["frame_class"].to_pylist() == ["", "", "Clear", "Contact"]


def test_truth_comes_back_with_its_units_in_the_column_names(tmp_path: Path, episode: Episode):
    row = written(tmp_path, episode).to_pylist()[3]
    assert row["gap_mm"] == -1.2
    assert (row["x_mm"], row["y_mm"], row["twist_deg"]) == (0.5, -0.25, 10.0)
    assert row["force_n"] == [0.1, 0.2, 3.0]
    assert row["torque_nmm"] == [-1.0, 2.0, 0.5]
    assert row["contact_area_mm2"] == 7.5
    assert row["depth_mm"] == 1.2
    assert row["time_s"] == pytest.approx(0.2)
    assert (row["iterations"], row["min_jacobian"]) == (9, 0.8)
    assert row["contact"] is True


def test_frames_say_how_light_and_image_were_made_and_nothing_where_nobody_knows(tmp_path: Path, episode: Episode):
    made = replace(episode.frames[3], origin=Origin(light="before contact", image="traced"))
    table = written(tmp_path, replace(episode, frames=(*episode.frames[:3], made)))
    assert table["light_way"].to_pylist() == ["", "", "", "before contact"]
    assert table["image_way"].to_pylist() == ["", "", "", "traced"]


def test_absent_object_has_a_gap_that_is_no_number(tmp_path: Path, episode: Episode):
    row = written(tmp_path, episode).to_pylist()[2]
    assert math.isnan(row["gap_mm"])
    assert row["contact"] is False


def test_contact_mask_decodes_from_its_png(tmp_path: Path, episode: Episode):
    png = written(tmp_path, episode)["contact_mask"][3].as_py()["bytes"]
    assert np.array_equal(cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_UNCHANGED), MASK * np.uint8(255))


def test_displacements_come_back_exactly_in_the_order_of_the_nodes(tmp_path: Path, episode: Episode):
    column = written(tmp_path, episode)["displacements_mm"]
    assert np.array_equal(np.array(column[3].as_py(), np.float32).reshape(-1, 3), MOVED)


def test_outputs_not_asked_for_are_null_in_the_same_columns(tmp_path: Path, episode: Episode):
    bare = Episode(scene=episode.scene, frames=(frame(0, UNTOUCHED, mask=None, moved=None),))
    row = written(tmp_path, bare).to_pylist()[0]
    assert row["contact_mask"] is None
    assert row["displacements_mm"] is None


def test_schema_does_not_depend_on_the_content(tmp_path: Path, episode: Episode):
    bare = Episode(scene=episode.scene, frames=(frame(0, UNTOUCHED, mask=None, moved=None),))
    assert written(tmp_path, bare).schema.equals(written(tmp_path, episode).schema)


def test_verdicts_of_every_profile_stand_beside_the_truth(tmp_path: Path, episode: Episode, judgement: Judgement):
    rows = written(tmp_path, episode, judgement).to_pylist()
    for key in (*NUMBERS, *WORDS):
        empty = rows[0][f"published_{key}"]
        assert math.isnan(empty) if key in NUMBERS else empty == ""
        assert rows[3][f"published_{key}"] == judgement.verdicts[1].as_dict()[key]
    assert rows[3]["published_contact"] == "Touched"


def test_lattice_has_the_rest_position_of_every_node(tmp_path: Path):
    planes = (np.array([-1.0, 0.0, 1.0]), np.array([-2.0, 2.0]), np.array([0.0, 3.0]))
    lattice = box_lattice(planes, shear_modulus_mpa=1.0, lame_mpa=1.0)
    write_places(tmp_path / "lattice.parquet", lattice.nodes_mm, {})
    table = pq.read_table(tmp_path / "lattice.parquet")
    assert table.column_names == ["x_mm", "y_mm", "z_mm"]
    assert np.array_equal(np.stack([table[name].to_numpy() for name in table.column_names], 1), lattice.nodes_mm)
