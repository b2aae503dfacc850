"""Which frames train, tell when to stop, and test: whole presses, units or objects, never single frames of them."""

from dataclasses import dataclass

import numpy as np

from magicsim.arrays import Index
from magicsim.errors import ConfigError


@dataclass(frozen=True, slots=True, kw_only=True)
class Split:
    """Rows of the frames of each part, ascending; no group is in two of them."""

    train: Index
    validation: Index
    test: Index


def fold(
    groups: Index, number: int, folds: int, *, validation_share: float, share: float = 1.0, seed: int = 0,
    inner: Index | None = None,
) -> Split:  # fmt: skip
    """One fold of a cross-validation over groups.

    A smaller share of the training groups is a part of a larger one's, and test and validation stay.

    Args:
        groups: Group of each frame, shape (n,).
        number: Which fold, from 0.
        folds: How many there are.
        validation_share: Share of the other groups that tell when to stop, at least one.
        share: Share of the training groups that are used, at least one.
        seed: Of the order in which groups are dealt.
        inner: Groups within which validation and share are chosen, such as presses where the folds are units; the
            groups themselves by default.

    Raises:
        ConfigError: There are fewer groups than folds, or too few to train on.
    """
    names = np.unique(groups)
    if len(names) < folds:
        msg = f"there are {len(names)} groups for {folds} folds: more of them are needed, or fewer folds"
        raise ConfigError(msg)
    order = np.random.default_rng([seed, folds]).permutation(names)
    held = order[number::folds]
    inner = groups if inner is None else inner
    rest = np.unique(inner[~np.isin(groups, held)])
    left = np.random.default_rng([seed, folds, number]).permutation(rest)
    stop = max(1, round(validation_share * len(left)))
    train = left[stop:]
    if not len(train):
        msg = f"there are {len(left)} groups beside those of the test: too few to train on"
        raise ConfigError(msg)
    train = train[: max(1, round(share * len(train)))]
    outside = ~np.isin(groups, held)
    return Split(
        train=np.flatnonzero(np.isin(inner, train) & outside),
        validation=np.flatnonzero(np.isin(inner, left[:stop]) & outside),
        test=np.flatnonzero(~outside),
    )
