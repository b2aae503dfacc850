"""The results of an evaluation as files, plots and one page."""
