"""Measures of a detector, their intervals, and tests of what changed."""
