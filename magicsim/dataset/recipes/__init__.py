"""Recipes: distributions over sensors, objects and paths, and what is drawn from them."""
