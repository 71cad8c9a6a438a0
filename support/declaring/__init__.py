"""Commands declared apart from their work, and what the shell completes of them."""
