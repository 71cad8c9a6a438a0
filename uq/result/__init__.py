"""Chains in, `Posterior` out: summary, record, the whole device."""
