"""The untouched sensor, rendered once with its paths taken down, kept in memory and on disk."""
