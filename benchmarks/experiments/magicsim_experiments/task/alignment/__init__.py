"""Alignment: two fingers hold a cylinder askew, a learned model reads its angle, and the wrist turns it upright."""
