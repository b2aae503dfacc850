"""What only the documentation's experiments need, beside the scripts that run it; the package does without."""
