import numpy as np
from learn.made import made_samples

from magicsim.dataset.recipes.recipe import load_recipe
from magicsim_experiments.learn.fitting import Fit, split_of
from magicsim_experiments.learn.settings import LearningSettings
from magicsim_experiments.study.learned.data import count_objects, planned_fits


def test_objects_of_choices_are_counted_and_drawn_sizes_are_not():
    assert count_objects(load_recipe("cylinders")) == 6  # three radii, two colours
    assert count_objects(load_recipe("localisation")) == 1
    assert count_objects(load_recipe("ranging")) == 0


def test_object_is_never_in_two_parts():
    settings = LearningSettings(folds=4, folds_used=2)
    fits = [fit for fit in planned_fits(settings, units=1, objects=6) if fit.split_by == "object"]
    assert [(fit.name, fit.folds) for fit in fits] == [("object-0", 4), ("object-1", 4)]
    samples = made_samples(24)
    split = split_of(samples, Fit(name="object-0", network="small", split_by="object", folds=4), settings, seed=1)
    assert len(np.unique(samples.object_of[split.test])) == 1
    for rows in (split.train, split.validation):
        assert not set(samples.object_of[rows]) & set(samples.object_of[split.test])
