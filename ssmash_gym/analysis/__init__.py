"""What it means: verification, metrics, plots."""
