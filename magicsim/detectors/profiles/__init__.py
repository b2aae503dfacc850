"""Detector profiles: thresholds and options, their files, and how they are fitted to labelled frames."""
