"""A sampling proxy for evaluation and layering networks that came without one."""

from collections.abc import Mapping

import numpy as np

from urushi.fan2022.architecture import PaperArchitecture, init
from urushi.fan2022.inference import layer
from urushi.fan2022.networks import PaperNetworks
from urushi.fan2022.palette import Palette
from urushi.fan2022.published import cosine_proxy
from urushi.fan2022.train import proxy
from urushi.nets.mlp import Params
from urushi.walk import analytic

#: Components of each kind, stacks of one coat, and incoming directions of their histograms.
COMPONENTS, STACKS, INCOMING = 16, 64, 12


def fitted_proxy(params: Mapping[str, np.ndarray], seed: int = 0) -> tuple[Params, float]:
    """Train a proxy on stacks whose codes the networks predict; returns its divergence too.

    Dielectrics and conductors of Table 2 are projected, by Levenberg-Marquardt, and layered. The
    proxy learns from the conductors and the stacks, as in `proxy.learn`.

    params: of the evaluation and the layering network.
    """
    source = Palette(1, components=COMPONENTS, stacks=STACKS, seed=seed)
    top, below, albedo, sigma_t = source.parts(slice(0, STACKS))
    networks = PaperNetworks(PaperArchitecture(), {**params, **cosine_proxy()}, {})
    wi, wo = networks.pairs()
    codes = {}
    for kind in ("dielectric", "conductor"):
        bare = Palette(0, kind, COMPONENTS, STACKS, seed)
        columns = bare.draw(np.random.default_rng(seed), slice(0, COMPONENTS)).bottom
        row = np.repeat(np.arange(COMPONENTS, dtype=np.uint32), len(wi))
        pairs = (np.tile(w, (COMPONENTS, 1)) for w in (wi, wo))
        f = analytic.rows(kind, columns, row, *pairs).reshape(COMPONENTS, -1)
        codes[kind] = networks.encode(f)
    medium = np.float32(albedo), np.float32(sigma_t)
    stacks = layer(params, codes["dielectric"][top], codes["conductor"][below], *medium)
    latents = np.concatenate([codes["conductor"], stacks]).astype(np.float32)
    data = proxy.histograms(params, latents, proxy.incoming(INCOMING, seed))
    return proxy.learn(init(seed), data)
