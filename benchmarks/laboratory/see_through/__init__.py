"""Simulated recordings of see-through sensors with markers: units, rooms and cameras drawn at random."""
