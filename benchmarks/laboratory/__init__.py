"""Library of the scripts of `benchmarks/`; the package does without."""
