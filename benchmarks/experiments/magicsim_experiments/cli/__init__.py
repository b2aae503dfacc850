"""The commands `study`, `estimate` and `task`."""
