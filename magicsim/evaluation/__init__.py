"""Detector benchmark: a fixed suite of episodes, measures with confidence intervals, and comparison with a baseline."""
