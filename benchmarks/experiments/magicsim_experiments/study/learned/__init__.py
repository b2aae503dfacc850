"""Studies that learn: data from a recipe, models trained on it, and how far their answers are from the truth."""
