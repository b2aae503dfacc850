"""Sweeps that choose their next designs in the knowledge of all before."""
