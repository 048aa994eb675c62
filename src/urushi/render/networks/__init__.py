"""The networks as Dr.Jit code, inside kernels: the twins of what `urushi.nets` does with NumPy."""
