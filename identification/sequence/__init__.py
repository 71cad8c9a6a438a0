"""Campaign in, fits of all configurations in locking order out, and the whole device from them."""
