"""Another finger that looks back at a sensor: its body, what it reflects, and the light of its strips."""
