"""The damped Gauss-Newton step that fits latent codes to values."""

from typing import Any


def damped_step(curvature: Any, slope: Any, damping: Any) -> Any:
    """Return the change (..., L) that is subtracted from the unknowns (Marquardt 1963).

    The damping is relative to the mean of the curvature's diagonal. One definition runs on NumPy
    and JAX.

    Args:
        curvature: (..., L, L) half the Hessian, by Gauss and Newton.
        slope: (..., L) half the gradient.
        damping: (...) or a number.
    """
    xp = curvature.__array_namespace__()
    size = curvature.shape[-1]
    mean = xp.linalg.trace(curvature) / size
    added = xp.asarray(damping * mean + 1e-12)[..., None, None]
    damped = curvature + added * xp.eye(size, dtype=curvature.dtype)
    return xp.linalg.solve(damped, slope[..., None])[..., 0]
