"""Factors of symmetric positive definite matrices: MKL PARDISO, or SuperLU where it is missing."""
