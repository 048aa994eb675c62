"""What noise-free BSDFs are worth under one light and another."""
