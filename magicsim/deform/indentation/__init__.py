"""Tests on a print: press, shear and twist, presses that take time, and Shore hardness."""
