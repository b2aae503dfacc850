"""Frames of a real sensor with their labels, as a dataset.

A TOML file says where frames and labels lie and what their columns are called; the result has the columns of a
simulated dataset, so that detectors, `fit` and learned models read it alike. Nothing is downloaded.
"""
