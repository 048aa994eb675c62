"""The plugins that scenes name, what they share, and the stack of coats that `layered` walks."""
