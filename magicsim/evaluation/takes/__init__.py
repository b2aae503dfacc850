"""Frames to judge: simulated once and kept, or recorded by a real sensor."""
