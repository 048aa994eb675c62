"""What `neural_brdf` and `neural_layered` share: a Mitsuba BSDF that evaluates latent codes."""

import mitsuba as mi

from urushi.nets import shipped
from urushi.nets.weights import Model
from urushi.render import spectrum
from urushi.render.codes.latents import ConstantLatents, TexturedLatents


def read_model(props: "mi.Properties") -> Model:
    """The networks that the property `weights` names, a shipped one or a file, else the default."""
    given = props.get("weights", shipped.NAMES[0])
    return shipped.find(given if given in shipped.NAMES else resolve(given))


def resolve(path: str) -> str:
    """Find a file as Mitsuba does: relative to the scene file, then to the working folder."""
    return str(mi.file_resolver().resolve(path))


def define(base: type) -> type:
    """Make the class in the current variant; base: `mixture_bsdf.define`'s class."""

    class NeuralBSDF(base):
        """A BRDF given by latent codes; subclasses set `model` and `latents`."""

        model: Model
        latents: ConstantLatents | TexturedLatents

        def save(self, path):
            """Write the codes to a file that ``neural_brdf`` loads, textured or not.

            Raises:
                FileError: it cannot be written.
            """
            self.latents.save(path)

        def _vertex(self, si, active):
            return self.latents.vertex(si, active)

        def _f(self, vertex, ctx, si, wo, active):
            channels = self.latents.f(vertex, si, wo, active)
            return spectrum.from_channels(channels, si.wavelengths)

        def _mixture(self, vertex, si, active):
            return vertex.mixture

    return NeuralBSDF
