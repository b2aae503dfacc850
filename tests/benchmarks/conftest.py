"""The tiny suite of the evaluation, for what is measured on it."""

from evaluation.conftest import evaluate, tiny

__all__ = ["evaluate", "tiny"]
