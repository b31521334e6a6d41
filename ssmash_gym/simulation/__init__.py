"""A batch of helicopters in time."""
