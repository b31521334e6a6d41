"""Evaluation: policies on the same frozen seeds, a table with intervals, plots and a film."""
