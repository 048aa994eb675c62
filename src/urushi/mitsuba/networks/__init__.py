"""Basis, lobe, proposal and tables as Dr.Jit code inside kernels."""
