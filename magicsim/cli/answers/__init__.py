"""Answers about the program itself: what this machine can do, what work will take, what files look like."""
