"""Error of packed latent textures: `python -m benchmarks.quality.packing`; some seconds.

Prints bytes per texel and the error E (docs/conventions.md) of packed codes, and of codes in half
precision, against the codes themselves: random coats over all ranges of their parameters, on random
conductors, three channels per texel; with one index for all, and with one for each channel. Coats
of the last rows have two GGX widths.
"""

import numpy as np

from urushi.checks import TRAINED_WIDTH_RATIO, CoatParameters, Widths
from urushi.core.direction_sets import cosine_pairs
from urushi.core.error_metrics import stack_error
from urushi.material import encode
from urushi.material.layer import layer_texels
from urushi.nets.weights import Model, anisotropic_model, default_model
from urushi.textures.store import TextureStore
from urushi.walk import conductor

TEXELS, BOTTOMS, PAIRS = 1024, 16, 128


def main() -> None:
    """Print the table."""
    print(f"{'indices':12}{'bytes':>8}{'mean E':>10}{'95 %':>10}{'half floats':>14}{'mean E':>10}")
    for model in (default_model(), anisotropic_model()):
        for name, low, high in (("1.5", 1.5, 1.5), ("1.2 to 1.8", 1.2, 1.8)):
            print(f"{name:12}{row(model, low, high)}", flush=True)


def row(model: Model, low: float, high: float) -> str:
    """The figures for coats of indices between two."""
    rng = np.random.default_rng(0)
    metals = [conductor(rng.uniform(0.05, 0.6), rng.random(3)) for _ in range(BOTTOMS)]
    bottoms = np.concatenate([encode(metal, model).latents for metal in metals])
    count = 3 * TEXELS
    along = np.repeat(0.01 * 100 ** rng.random(TEXELS), 3)
    ratios = np.repeat(TRAINED_WIDTH_RATIO ** rng.uniform(-1, 1, TEXELS), 3)
    across = np.clip(along * ratios, 0.01, 1)
    codes = layer_texels(
        model,
        bottoms[rng.integers(len(bottoms), size=count)],
        CoatParameters(
            alpha=along if model.widths == 1 else Widths(along, across),
            eta=rng.uniform(low, high, count),
            albedo=rng.random(count),
            sigma_t=rng.exponential(1, count),
            g=rng.uniform(-0.7, 0.7, count),
        ),
    )
    texels = codes.reshape(TEXELS, 3, -1)
    store = TextureStore(model, 3, TEXELS)
    store.write(slice(None), texels)
    wi, wo = cosine_pairs(rng, PAIRS)
    f = model.networks.f(codes[:, None], wi, wo)
    stored = store.read(slice(None)).reshape(codes.shape), codes.astype(np.float16)
    ours, half = (
        stack_error(model.networks.f(np.float32(z)[:, None], wi, wo), f, wi[:, 2], wo[:, 2])
        for z in stored
    )
    return (
        f"{store.layout.texel_bytes:8}{ours.mean():10.3%}{np.quantile(ours, 0.95):10.3%}"
        f"{2 * texels[0].size:14}{half.mean():10.3%}"
    )


if __name__ == "__main__":
    main()
