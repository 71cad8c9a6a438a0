"""Steps of the sequence in, what a reader gets out: summary, curves, figures beside the plain model, draws."""
