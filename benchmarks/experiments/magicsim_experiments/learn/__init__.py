"""Learned models that read frames: data from a dataset's Parquet, training that resumes, files, scores and baselines.

What needs PyTorch (extra `learn`) is in `networks`, `weights`, `losses`, `training` and `reading`; the rest does not.
"""
