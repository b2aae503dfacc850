"""Whether the fast tier changes verdicts: detectors on the suite's takes by either tier, frame by frame.

    python benchmarks/tier_verdicts.py WORK --out docs/benchmarks/tier-verdicts.json      # takes are kept in WORK

The suite `small` is rendered truly and by the fast tier, and each profile judges both. A verdict agrees where both
detectors say the same of a frame; intervals draw whole episodes again. What a tier changes is beside what another seed
of the camera's noise changes of true frames, on the same takes.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

from magicsim.judge.measures import ends, resampled

PROFILES, RESAMPLES = ("published", "calibrated"), 4000
CASES = {"true": ("--seed", "1"), "fast": ("--seed", "1", "--set", "render.tier=fast"), "noise": ("--seed", "2")}


def verdicts(work: Path, profile: str, case: str) -> dict[str, list[str]]:
    """What is said of all frames, by episode: a letter each of proximity and contact."""
    path = work / f"{profile}-{case}.json"
    command = [
        sys.executable, "-m", "magicsim", "evaluate", "small", "--profile", profile, "--cache", str(work / "takes"),
        "--out", str(work / f"{profile}-{case}"), "--save-baseline", str(path), "--allow-weak", *CASES[case],
    ]  # fmt: skip
    subprocess.run(command, check=False, stdout=subprocess.DEVNULL)  # 1 where a class is never named
    episodes = json.loads(path.read_text("utf-8"))["episodes"]
    return {name: list(map("".join, zip(each["proximity"], each["contact"], strict=True)))
            for name, each in episodes.items()}  # fmt: skip


def compared(first: dict[str, list[str]], second: dict[str, list[str]]) -> dict[str, Any]:
    """How many frames have the same class, as a share with its interval."""
    same = np.array([sum(a == b for a, b in zip(first[name], second[name], strict=True)) for name in first])
    frames = np.array([len(each) for each in first.values()])
    drawn = resampled(len(frames), RESAMPLES, np.random.default_rng(0))
    shares = same[drawn].sum(1) / frames[drawn].sum(1)
    share = round(float(same.sum() / frames.sum()), 4)
    return {"frames": int(frames.sum()), "agree": share, "interval": np.round(ends(shares), 4).tolist()}


def main() -> None:
    """See the module."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("work", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    chosen = parser.parse_args()
    chosen.work.mkdir(parents=True, exist_ok=True)
    found = {}
    for profile in PROFILES:
        said = {case: verdicts(chosen.work, profile, case) for case in CASES}
        found[profile] = {case: compared(said["true"], said[case]) for case in ("fast", "noise")}
    print(json.dumps(found, indent=1))
    chosen.out.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
