"""Learned models that read frames: data from a dataset's Parquet, training that resumes, files, scores and baselines.

What needs PyTorch (extra `learn`) is in `networks` and `training`; the rest does not import it before it is used.
"""
