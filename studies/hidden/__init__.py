"""Cases of blind studies: what is hidden, how large; knows the virtual device and no model."""
