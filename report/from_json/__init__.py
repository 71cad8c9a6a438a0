"""Results that have no stored page in, a plain page of their tables out."""
