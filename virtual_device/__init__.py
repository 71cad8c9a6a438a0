"""An independent truth: own equations, own integrator; it makes the synthetic campaigns and knows nothing of the model."""
