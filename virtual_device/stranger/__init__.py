"""Another machine on purpose: friction laws and disturbances whose formulas are not those of the first."""
