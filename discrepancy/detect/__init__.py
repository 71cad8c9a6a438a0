"""Solution in, tests out: omnibus, score tests, family-wise p, residual localisation."""
