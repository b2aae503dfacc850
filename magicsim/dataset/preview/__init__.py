"""A look at a recipe before a long run."""
