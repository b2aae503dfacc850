"""Does `evaluate` notice a fault, and does it stay silent where nothing changed?

    python benchmarks/injected_regressions.py --cache magicsim-takes --out docs

Films the small suite into the cache (once: twelve dark takes and two lit ones; a run that is cut off goes on), judges
it with the sound detectors as the baseline, then with one fault at a time, then ten times with the sound ones under
other camera noise. Writes `injected-regressions.json`: for every run its alarms, and what became better. Exit code 1
where a fault passes unnoticed that makes nothing better, or a rerun raises an alarm.
"""

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from laboratory.injected_faults import FAULTS

from magicsim.detectors import load_profile
from magicsim.evaluation.answers import judge_footage
from magicsim.evaluation.baseline import load_baseline, save_baseline, set_beside
from magicsim.evaluation.detector import MakeDetector, ProfileDetector
from magicsim.evaluation.evaluate import film_suite
from magicsim.evaluation.suite import SuiteConfig, load_suite
from magicsim.judge.regression import Change
from magicsim.judge.tally import JudgedEpisode


def judge(suite: SuiteConfig, cache: Path, make: MakeDetector) -> list[JudgedEpisode]:
    """All episodes of a suite."""
    return [judge_footage(film, make, who="built-in") for films in film_suite(suite, cache) for film in films]


def changes_since(baseline: Path, episodes: Sequence[JudgedEpisode], *, seed: int) -> list[Change]:
    """All measures beside those of a baseline."""
    known = load_baseline(baseline)
    return set_beside(known, episodes, suite=known.suite, detector=known.detector, seed=seed).changes


def alarms(changes: Sequence[Change]) -> list[dict[str, Any]]:
    """What fell significantly, as `magicsim evaluate` would say."""
    return [
        {
            "condition": each.condition,
            "measure": each.measure,
            "fall": each.fall,
            "p": each.p_fall_corrected,
        }
        for each in changes
        if each.is_regression
    ]


def gains(changes: Sequence[Change]) -> list[str]:
    """What rose, likewise."""
    return [f"{each.condition} {each.measure}" for each in changes if each.is_improvement]


def main() -> None:
    """Judges every fault and every rerun."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cache", type=Path, required=True)
    parser.add_argument("--suite", default="small")
    parser.add_argument("--profile", default="calibrated")
    parser.add_argument("--reruns", type=int, default=10)
    parser.add_argument("--set", dest="settings", action="append", default=[], help="of the suite, as in evaluate")
    parser.add_argument("--out", type=Path, default=Path("docs"))
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    suite, profile = load_suite(given.suite, given.settings), load_profile(given.profile)
    sound = judge(suite, given.cache, lambda: ProfileDetector(profile))
    baseline = given.cache / "sound.json"
    save_baseline(baseline, sound, suite=given.suite, detector=given.profile)
    faults: dict[str, dict[str, Any]] = {}
    reruns: dict[int, list[dict[str, Any]]] = {}
    for name, fault in FAULTS.items():
        faulty = judge(suite, given.cache, lambda fault=fault: fault.make(profile))  # type: ignore[misc]
        changes = changes_since(baseline, faulty, seed=suite.seed)
        faults[name] = {"says": fault.says, "alarms": alarms(changes), "gains": gains(changes)}
        noticed = [each["measure"] for each in faults[name]["alarms"]] or "unnoticed"
        print(f"{name} ({fault.says}): {noticed}; better: {faults[name]['gains'] or 'nothing'}", flush=True)
    for seed in range(1, given.reruns + 1):
        other = suite.model_copy(update={"seed": seed})
        again = judge(other, given.cache, lambda: ProfileDetector(profile))
        reruns[seed] = alarms(changes_since(baseline, again, seed=suite.seed))
        print(f"seed {seed}: {[each['measure'] for each in reruns[seed]] or 'silent'}", flush=True)
    result = {
        "kind": "injected-regressions", "suite": given.suite, "profile": given.profile,
        "takes": len({each.tag.take for each in sound}), "faults": faults, "reruns": reruns,
    }  # fmt: skip
    (given.out / "injected-regressions.json").write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    missed = [name for name, each in faults.items() if not each["alarms"] and not each["gains"]]
    false = [seed for seed, each in reruns.items() if each]
    print(f"unnoticed: {missed or 'none'}; false alarms: {false or 'none'}")
    sys.exit(1 if missed or false else 0)


if __name__ == "__main__":
    main()
