"""Makes the frames of `magicsim evaluate --quick`: the dark takes of the suite `small`, with fewer states.

    python benchmarks/quick_set.py --cache magicsim-takes
    magicsim evaluate --quick --save-baseline detectors/baselines/quick-calibrated.json

Renders takes of the suite that the cache does not hold. Of the story's 34 frames 12 states are kept, which make 26
frames: states that stay are seen twice, with other noise. Images have whole grey levels, at the brightness that the
camera is exposed for; what an object changes by more than 127 of them is clipped, which is told.
"""

import argparse
import json
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from magicsim.config.program import versions
from magicsim.evaluation.footage import FINER, INDEX, LIGHT, MIDDLE, UNTOUCHED, quick_suite
from magicsim.evaluation.suite import SHIPPED, load_suite
from magicsim.evaluation.take import Case, Take, cached_take, list_cases

LIT = 3
"""States without an object and with the flashlight on, the last ones of each take."""
STORY = (0, 1, 2, 9, 9, 12, 12, 14, 14, 16, 16, 19, 19, 20, 20, 22, 23, 23, 25, 25, 28, 28, 30, 30, 32, 32)
"""Frames of the story that the set's frames show: untouched, 9, 3, 1 and 0.1 mm away, 0.3 mm deep, all and half of the
depth, 0.5 mm away, untouched, and the flashlight at three places."""
MOST_BYTES = 5_000_000


def write_png(path: Path, image: np.ndarray) -> None:
    """Writes the smallest of what the strategies of zlib make of an image."""
    made = [
        cv2.imencode(".png", image, [cv2.IMWRITE_PNG_COMPRESSION, 9, cv2.IMWRITE_PNG_STRATEGY, strategy])[1].tobytes()
        for strategy in range(4)
    ]
    path.write_bytes(min(made, key=len))


def short(take: Take) -> Take:
    """A dark take with its references and the frames of `STORY` alone."""
    first = int(take.is_reference.sum())
    frames = np.r_[:first, first + np.array(STORY)]
    states, shown = np.unique(take.state[frames], return_inverse=True)
    return replace(
        take, radiance=take.radiance[states], state=shown.astype(np.int32), is_reference=take.is_reference[frames],
        gap_mm=take.gap_mm[frames], force_n=take.force_n[frames], flashlight=take.flashlight[frames],
    )  # fmt: skip


def changes(take: Take, grey: float, states: slice, kind: str) -> np.ndarray:
    """Changes of some states against the untouched one in whole grey levels, one below the other, of a type."""
    whole = np.concatenate(np.rint((take.radiance[states] - take.radiance[0]) / grey))
    if clipped := int((np.abs(whole) > MIDDLE[kind] - 1).sum()):
        print(f"{clipped} of {whole.size} values are clipped")
    return np.clip(whole + MIDDLE[kind], 0, 2 * MIDDLE[kind] - 1).astype(kind)


def pack(takes: Iterable[tuple[Case, Take]], out: Path) -> int:
    """Writes images and index, and gives their size in bytes."""
    out.mkdir(parents=True, exist_ok=True)
    entries, index = {}, {}
    for case, take in takes:
        grey = float(take.radiance[0].mean()) / case.scene.rig.camera.exposure_grey
        write_png(out / f"{case.object}.png", changes(take, grey, slice(1, -LIT), "uint8"))
        if not entries:
            write_png(out / LIGHT, changes(take, grey, slice(-LIT, None), "uint16"))
            write_png(out / UNTOUCHED, np.rint(take.radiance[0] / grey * FINER).astype(np.uint16))
        shown = ~take.is_reference
        index = {"grey": grey, "state": take.state[shown].tolist(), "flashlight": take.flashlight[shown].tolist()}
        entries[case.name] = {
            "file": f"{case.object}.png",
            "gap_mm": [None if np.isnan(each) else round(float(each), 6) for each in take.gap_mm[shown]],
            "force_n": [round(float(each), 6) for each in take.force_n[shown]],
        }
    index |= {"takes": entries, "made_by": versions()}
    (out / INDEX).write_text(json.dumps(index, indent=1) + "\n", encoding="utf-8")
    return sum(path.stat().st_size for path in out.iterdir())


def main() -> None:
    """Films and packs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cache", type=Path, required=True)
    parser.add_argument("--out", type=Path, default=Path("detectors/quick"))
    given = parser.parse_args()
    cases = list_cases(quick_suite(load_suite(SHIPPED))[0])
    size = pack(((case, short(cached_take(case.scene, given.cache))) for case in cases), given.out)
    print(f"{len(cases)} takes, {size} bytes")
    assert size <= MOST_BYTES


if __name__ == "__main__":
    main()
