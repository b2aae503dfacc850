"""Fixtures of the detectors, for labelled folders of images."""

from detectors.conftest import save

__all__ = ["save"]
