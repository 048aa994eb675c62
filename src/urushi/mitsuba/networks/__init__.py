"""The networks of `urushi.nets` as Dr.Jit code inside kernels."""
