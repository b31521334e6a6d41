"""Training: one YAML file becomes a run folder with a trained agent in it."""
