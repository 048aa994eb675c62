"""Error of the tables by which constant materials are rendered: `material.table`.

Command: `python -m benchmarks.quality.table`; half a minute on one core.

Prints, for bare surfaces and coats over them, the error E of f by table against f by the decoder,
the median relative difference and the 99th percentile, over cosine-distributed pairs and pairs near
the mirror direction. The last materials have two GGX widths.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

import urushi
from urushi.core import error_metrics
from urushi.core.direction_sets import cosine_pairs, half_angle_pairs
from urushi.material import Material

PAIRS = 20_000


def materials() -> dict[str, Material]:
    """Materials by name."""
    conductor, dielectric, layer = urushi.conductor, urushi.dielectric, urushi.layer
    gold = conductor(0.3, r0=(0.9, 0.6, 0.3))
    return {
        "diffuse": urushi.encode(urushi.diffuse(0.5)),
        "lacquer on diffuse": layer(dielectric(0.05, 1.5), urushi.diffuse(0.5)),
        "amber on gold": layer(dielectric(0.1, 1.5), gold, sigma_t=(0.5, 0.2, 0.1), albedo=0.5),
        "clear coat on satin metal": layer(dielectric(0.02, 1.3), conductor(0.1, r0=0.9)),
        "clear coat on polished metal": layer(dielectric(0.02, 1.5), conductor(0.03, r0=0.9)),
        "two coats": layer(
            dielectric(0.3, 1.5), layer(dielectric(0.02, 1.5), gold, sigma_t=1, albedo=0.9)
        ),
        "lacquer on brushed metal": layer(
            dielectric(0.05, 1.5),
            conductor(alpha_u=0.08, alpha_v=0.4, r0=(0.9, 0.6, 0.3)),
            sigma_t=0.3,
            albedo=0.5,
        ),
        "clear coat on hairline metal": layer(
            dielectric(0.02, 1.5), conductor(alpha_u=0.03, alpha_v=0.24, r0=0.9)
        ),
        "brushed coat on diffuse": layer(
            dielectric(alpha_u=0.05, alpha_v=0.3, eta=1.5),
            urushi.diffuse(0.5),
            sigma_t=1,
            albedo=0.8,
        ),
        "brushed coat on brushed metal": layer(
            dielectric(alpha_u=0.3, alpha_v=0.05, eta=1.5),
            conductor(alpha_u=0.05, alpha_v=0.3, r0=0.7),
            sigma_t=0.5,
            albedo=0.8,
        ),
    }


def rendered(material: Material, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """f (N, C) by the plugins' table."""
    from urushi.mitsuba.latents.holders import ConstantLatents  # after the variant is chosen

    latents = ConstantLatents(Material(material.latents, material.model))
    si = dr.zeros(mi.SurfaceInteraction3f, len(wi))
    si.wi = mi.Vector3f(np.ascontiguousarray(wi.T))
    active = dr.full(mi.Bool, True, len(wi))
    outgoing = mi.Vector3f(np.ascontiguousarray(wo.T))
    channels = latents.f(latents.vertex(si, active), si, outgoing, active)
    return np.stack([channel.numpy() for channel in channels], axis=-1)


def main() -> None:
    """Print the table."""
    mi.set_variant("llvm_ad_rgb")
    rng = np.random.default_rng(0)
    cosine, mirror = cosine_pairs(rng, PAIRS), half_angle_pairs(rng, PAIRS)
    both = [np.concatenate(pair).astype(np.float32) for pair in zip(cosine, mirror, strict=True)]
    print(f"{'':<28}{'E':>9}{'median':>9}{'99 %':>9}")
    for name, material in materials().items():
        f, exact = (g(*both) for g in (lambda *w, m=material: rendered(m, *w), material.f))
        relative = np.abs(f / exact - 1)
        wi, wo = (w[:PAIRS, 2] for w in both)
        error = error_metrics.stack_error(f[:PAIRS].T, exact[:PAIRS].T, wi, wo).mean()
        quantiles = np.quantile(relative, (0.5, 0.99))
        print(f"{name:<28}{error:9.3%}" + "".join(f"{value:9.3%}" for value in quantiles))


if __name__ == "__main__":
    main()
