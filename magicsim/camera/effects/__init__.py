"""What a real camera adds to an ideal frame, each effect by itself on plain arrays."""
