"""Synthetic datasets: a recipe of distributions becomes shards of labelled frames."""
