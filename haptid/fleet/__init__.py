"""Campaigns of several devices in, a comparison of their identified parameters out."""
