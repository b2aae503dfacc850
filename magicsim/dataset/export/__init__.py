"""Datasets in the layouts of other libraries."""
