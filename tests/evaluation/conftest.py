"""Fixtures of this folder's tests."""

from tests.evaluation.studies import agents_without_training, helicopters_read_once

__all__ = ["agents_without_training", "helicopters_read_once"]
