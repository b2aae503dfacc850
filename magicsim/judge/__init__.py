"""Verdicts on an episode, the folder that a main job leaves, and detector profiles fitted to episodes."""
