"""Filters of magnified latent textures: `python -m benchmarks.quality.magnified`; 4 minutes.

Three filters are compared on textures of which a texel covers many pixels: codes interpolated
linearly (as in Fan et al. 2022), f of the four nearest texels interpolated, and one of the four
drawn in proportion to its weight, which is what Urushi does. Prints the mean of the picture
relative to that of interpolated f, the root mean square noise of 16 samples per pixel relative to
the mean, and the CPU time relative to interpolated codes (the least of `--repeats` renderings that
take turns). The plane is lit by a sky and a sun.
"""

import argparse
import operator
import time
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

import urushi  # noqa: F401  (registers the plugins)

mi.set_variant("llvm_ad_rgb")
from urushi.mitsuba.latents import lookup  # noqa: E402  (needs a variant)
from urushi.mitsuba.latents.holders import TexturedLatents, Vertex  # noqa: E402

#: Width and height of the pictures, and samples of the reference.
SIDE, REFERENCE_SPP, SPP = 128, 256, 16


class FourTexels(TexturedLatents):
    """The texels around a point, instead of one of them."""

    def __init__(self, latents: TexturedLatents):
        self.__dict__ = dict(latents.__dict__)

    def _texels(self, uv) -> tuple[list, list]:
        """Codes of the four texels, and their weights."""
        texture = self._texture
        sizes, point = texture._size, texture._to_texture(uv.x, uv.y)
        sides = []
        for x, count in zip(point, sizes, strict=True):
            place = x * mi.Float(count) - 0.5
            second = place - dr.floor(place)
            sides.append(((1e-4, 1 - second), (1 - 1e-4, second)))
        codes, weights = [], []
        for across, v in sides[0]:
            for along, w in sides[1]:
                texel = lookup.drawn_texel(point, sizes, self.grid, (across, along))
                codes.append(texture._codes(texture._gather(texel))[: self._kept])
                weights.append(v * w)
        return codes, weights


class InterpolatedCodes(FourTexels):
    """Codes interpolated linearly."""

    def _vertex(self, wi, uv) -> Vertex:
        codes, weights = self._texels(uv)
        mean = [
            [sum(map(operator.mul, weights, number)) for number in zip(*channel, strict=True)]
            for channel in zip(*codes, strict=True)
        ]
        return self._vertex_of(mean, wi)


class InterpolatedValues(FourTexels):
    """f of four texels interpolated linearly; directions are proposed for the drawn one."""

    def __init__(self, latents: TexturedLatents):
        super().__init__(latents)
        self._drawn, self._decoder = latents, Sum(latents._decoder, self._kept)

    def _vertex(self, wi, uv) -> Vertex:
        codes, weights = self._texels(uv)
        terms = [self._drawn._vertex_of(z, wi).decoder_terms for z in codes]
        joined = [channel for texel in terms for channel in texel]
        return Vertex([*joined, weights], self._drawn._vertex(wi, uv).proposal)


class Sum:
    """A decoder of the weighted terms of several codes."""

    def __init__(self, decoder, channels: int):
        self.decoder, self._channels = decoder, channels

    def f_of_terms(self, terms, wi, wo) -> list:
        """The weighted sum of f."""
        *parts, weights = terms
        total = [mi.Float(0)] * self._channels
        for index, weight in enumerate(weights):
            own = parts[index * self._channels : (index + 1) * self._channels]
            values = self.decoder.f_of_terms(own, wi, wo)
            total = [a + weight * b for a, b in zip(total, values, strict=True)]
        return total


FILTERS = {"codes": InterpolatedCodes, "values": InterpolatedValues, "drawn": lambda x: x}


def bitmap(pixels) -> dict[str, Any]:
    """A texture of linear values (H, W, channels)."""
    return {"type": "bitmap", "bitmap": mi.Bitmap(np.float32(pixels)), "raw": True}


def materials() -> dict[str, dict[str, Any]]:
    """The coats, by name."""
    rng = np.random.default_rng(0)
    gold = {"type": "roughconductor", "material": "Au", "alpha": 0.2, "distribution": "ggx"}
    clear = {"type": "neural_layered", "alpha": 0.1}

    def halves(a: float, b: float) -> dict[str, Any]:
        return bitmap([[[a], [b]], [[b], [a]]])

    def diffuse(reflectance: Any) -> dict[str, Any]:
        return {"type": "diffuse", "reflectance": reflectance}

    white = diffuse(0.5)
    return {
        "reflectance .02, .9": {**clear, "base": diffuse(halves(0.02, 0.9))},
        "sigma_t 0, 8 over gold": {**clear, "sigma_t": halves(0.0, 8.0), "base": gold},
        "albedo 0, 1": {**clear, "sigma_t": 2.0, "albedo": halves(0.0, 1.0), "base": white},
        "alpha .05, .5 over gold": {**clear, "alpha": halves(0.05, 0.5), "base": gold},
        "16² noise": {**clear, "base": diffuse(bitmap(rng.random((16, 16, 3))))},
        "256² noise": {**clear, "base": diffuse(bitmap(rng.random((256, 256, 3))))},
    }


def scene(bsdf: "mi.BSDF") -> "mi.Scene":
    """A plane of a material that fills the picture, under a sky and a sun."""
    view = mi.ScalarTransform4f().look_at([0, -1.2, 1.6], [0, 0, 0], [0, 1, 0])
    film = {"type": "hdrfilm", "width": SIDE, "height": SIDE, "rfilter": {"type": "box"}}
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 2},
            "sensor": {"type": "perspective", "fov": 35, "to_world": view, "film": film},
            "plane": {"type": "rectangle", "bsdf": bsdf},
            "sky": {"type": "constant", "radiance": 0.5},
            "sun": {"type": "directional", "direction": [0.3, 0.6, -1], "irradiance": 1.0},
        }
    )


def measure(name: str, described: dict[str, Any], repeats: int) -> None:
    """Print the rows of a material."""
    scenes, times = {}, dict.fromkeys(FILTERS, np.inf)
    for kind, filtered in FILTERS.items():
        bsdf = mi.load_dict(described)
        bsdf.latents = filtered(bsdf.latents)
        scenes[kind] = scene(bsdf)

    def picture(kind: str, spp: int, seed: int) -> np.ndarray:
        return mi.render(scenes[kind], spp=spp, seed=seed).numpy()

    exact = picture("values", REFERENCE_SPP, 1)
    for _ in range(repeats):
        for kind in FILTERS:
            start = time.process_time()
            picture(kind, REFERENCE_SPP, 3)
            times[kind] = min(times[kind], time.process_time() - start)
    for kind in FILTERS:
        own = exact if kind != "codes" else picture(kind, REFERENCE_SPP, 2)
        noisy = picture(kind, SPP, 4)
        mean = picture(kind, REFERENCE_SPP, 5).mean() / exact.mean() - 1
        noise = np.sqrt(np.square(noisy - own).mean()) / own.mean()
        cost = times[kind] / times["codes"]
        print(f"{name:26}{kind:8}{100 * mean:8.1f} %{100 * noise:8.1f} %{cost:8.2f}", flush=True)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.quality.magnified",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--repeats", type=int, default=3, help="renderings of each that are timed")
    arguments = parser.parse_args()
    print(f"{'':26}{'filter':8}{'mean':>10}{'noise':>10}{'time':>8}")
    for name, described in materials().items():
        measure(name, described, arguments.repeats)


if __name__ == "__main__":
    main()
