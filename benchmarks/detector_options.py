"""What each choice that the publication leaves open changes, one at a time, on the frames of a simulated episode.

    magicsim simulate demo --out RUN
    python benchmarks/detector_options.py RUN [--out docs]

Writes `detector-options.csv`. Each option is changed alone, in the
published profile and in the calibrated one. Medians of the features are given by true class, and balanced accuracies
with the profile's thresholds and with thresholds fitted anew to these very frames, which shows what the choice itself
can do, with the half gap around the fitted thresholds in standard deviations within the classes.
"""

import argparse
import csv
import statistics
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from magicsim.detectors import (
    Candidates,
    Episode,
    FrameClass,
    detect_all,
    fit_profile,
    fuse,
    load_profile,
    score_verdicts,
)
from magicsim.errors import MagicsimError
from magicsim.judge.recorded import read_episode

CHANGES: tuple[dict[str, int | float | str], ...] = (
    {},
    {"polarity": "dark"}, {"polarity": "bright"},
    {"similarity": "recall"}, {"similarity": "iou"}, {"similarity": "dice"},
    {"polarity": "dark", "similarity": "iou"}, {"polarity": "bright", "similarity": "iou"},
    {"tau_b": 25}, {"tau_b": 35}, {"tau_b": 45}, {"tau_b": 60},
    {"grid_blur_px": 0}, {"grid_blur_px": 3}, {"grid_blur_px": 9}, {"grid_blur_px": 5, "grid_blur_sigma_px": 2.0},
    {"grid_reference": "majority"}, {"surround_px": 6, "tau_b": 95}, {"surround_px": 6, "tau_b": 100},
    {"grey": "mean"}, {"grey_rounding": "down"}, {"entropy_bins": 64}, {"entropy_bins": 16},
    {"difference_blur_px": 3}, {"difference_blur_px": 5}, {"difference_blur_px": 9},
    {"constant_channel": "skip"},
    {"background_count": 1}, {"background_count": 6},
    {"reference_count": 6}, {"reference_count": 15},
)  # fmt: skip
FEATURES = ("entropy", "correlation", "similarity")


@dataclass(frozen=True, slots=True, kw_only=True)
class OptionEffect:
    """One changed option."""

    base: str
    changed: dict[str, int | float | str]
    medians: dict[str, dict[str, float]]
    """Of entropy [bit], correlation and similarity, by true class."""
    proximity_accuracy: float | None
    """With the base's thresholds."""
    contact_accuracy: float | None
    refitted_proximity_accuracy: float
    """With thresholds fitted to these frames."""
    refitted_contact_accuracy: float | None
    proximity_margin: float
    """Half the smaller gap around the fitted tau_e and tau_c, in standard deviations within classes."""
    contact_margin: float | None


def effect(base: str, changed: dict[str, int | float | str], episode: Episode) -> OptionEffect | None:
    """The effect of one change; None where it changes nothing or leaves no grid."""
    before = load_profile(base)
    profile = replace(before, **changed)  # type: ignore[arg-type]
    if changed and profile == before:
        return None
    verdicts = detect_all(episode.frames, fuse(episode.references, profile), profile)
    score = score_verdicts(verdicts, episode.classes)
    own = Candidates(
        tau_b=(profile.tau_b,),
        polarity=(profile.polarity,),
        similarity=(profile.similarity,),
        grid_blur_px=(profile.grid_blur_px,),
        difference_blur_px=(profile.difference_blur_px,),
    )
    fitted = fit_profile(profile, [episode], own).best
    return OptionEffect(
        base=base,
        changed=changed,
        medians={name: medians(verdicts, episode, name) for name in FEATURES},
        proximity_accuracy=score.proximity.accuracy,
        contact_accuracy=score.contact.accuracy,
        refitted_proximity_accuracy=fitted.proximity_accuracy,
        refitted_contact_accuracy=fitted.contact_accuracy,
        proximity_margin=round(fitted.proximity_margin, 3),
        contact_margin=None if fitted.contact_margin is None else round(fitted.contact_margin, 3),
    )


def medians(verdicts: list, episode: Episode, name: str) -> dict[str, float]:
    """Median of one feature for each class."""
    pairs = list(zip(verdicts, episode.classes, strict=True))
    return {
        str(wanted): round(statistics.median(getattr(one, name) for one, each in pairs if each is wanted), 4)
        for wanted in FrameClass
    }


def profile_names() -> tuple[str, ...]:
    """The profiles whose options are changed."""
    return ("published", "calibrated")


def write_table(effects: list[OptionEffect], path: Path) -> None:
    """A row of the CSV file for each changed option: medians by class, accuracies, margins."""
    rows = [
        {"profile": one.base, "changed": ", ".join(f"{name} = {value}" for name, value in one.changed.items())}
        | {f"{name}_{each}": value for name in FEATURES for each, value in one.medians[name].items()}
        | {name: value for name, value in asdict(one).items() if name.endswith(("accuracy", "margin"))}
        for one in effects
    ]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(
            {key: round(value, 4) if isinstance(value, float) else value for key, value in row.items()} for row in rows
        )


def main() -> None:
    """Measures every change and writes the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path)
    parser.add_argument("--out", type=Path, default=Path("docs"))
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    episode = read_episode(arguments.run)
    effects, refused = [], 0
    for base in profile_names():
        for changed in CHANGES:
            try:
                found = effect(base, changed, episode)
            except MagicsimError:
                refused += 1
                continue
            effects += [found] if found is not None else []
    write_table(effects, arguments.out / "detector-options.csv")
    print(f"{len(effects)} effects, {refused} refused")


if __name__ == "__main__":
    main()
