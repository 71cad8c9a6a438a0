"""Search result in, verdict and next experiment out."""
