"""Two faults of position-free walks, put into ours on purpose: what each does to its values."""
