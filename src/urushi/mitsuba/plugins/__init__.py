"""The plugins, their base classes, and the stack of coats that `layered` walks through."""
