"""OpenPBR's bases that transmit light: bodies of glass, and thin walls.

A `Body` mixes two-sided BSDFs by the shares of the base: opaque, an interface with a
medium below it (`Glass`), a thin wall that scatters light (`Sheet`), and slabs of the plugins
`layered` and `neural_layered` (`slabs`): coats on glass, panes, and panes with coats on both sides.
What has the index of what lies outside lets light pass straight on (`Unseen`).
Departures from the specification: a share that is opaque looks the same from inside; both sides of
a thin wall have the coat; specular_weight changes the index of the body, whatever lies above it.
"""

import drjit as dr
import mitsuba as mi

from urushi.errors import ParameterError
from urushi.mitsuba.snapshot import has_gradients
from urushi.mitsuba.surface import bsdf_of
from urushi.openpbr_surface.bsdfs import OF_COAT, Blend, Layer, OpenPBRSurface
from urushi.openpbr_surface.parts import SHARES, index_of, opaque_share
from urushi.openpbr_surface.slabs import Slab
from urushi.openpbr_surface.two_sided import Glass, Sheet, Unseen


class Body(Blend):
    """A surface that transmits light: a mixture of two-sided BSDFs."""

    def _configure(self):
        """Make the layers that parameters need."""
        self._ior: float | None = None  # until all are made
        inputs, index = self._inputs, index_of(self._inputs)
        parts, unseen = [], []
        rest = opaque_share(inputs)
        if rest is not None:
            parts.append(Layer(bsdf_of(OpenPBRSurface(rest, self._coating)), "opaque"))
        clear, scatters = map(inputs.transmits, SHARES[1:])
        if inputs.thin and scatters:
            parts.append(Layer(bsdf_of(Sheet(inputs)), "scattering"))
        if clear or (scatters and not inputs.thin):
            share = "clear" if inputs.thin else "transmitting"
            for coated, absent in ((False, 1), (True, 0)):
                if inputs.is_constant("coat_weight", absent):
                    continue
                if Unseen.is_right(inputs, coated):
                    unseen.append(Layer(Unseen(inputs, coated), share, coated))
                    continue
                slab = coated or inputs.thin
                surface = Slab(inputs, self._coating, coated) if slab else Glass(inputs)
                parts.append(Layer(bsdf_of(surface), share, coated))
        self._layers, self._unseen, self._ior = parts, unseen, index
        self._transmit(None if inputs.thin else index)

    def _flags(self):
        flags = mi.BSDFFlags
        straight = [flags.Null | flags.FrontSide | flags.BackSide] if self._unseen else []
        return [*super()._flags(), *straight]

    def _straight(self, ctx, si, active):
        """Probability that light goes straight on, and the mean transmittance there."""
        share, total = mi.Float(0), mi.Spectrum(0)
        for layer, own in zip(self._unseen, self._weights(self._unseen, si, active), strict=True):
            share += own
            total += own * layer.bsdf.passed(si, active)
        seen = mi.Bool(active) & (si.wi.z != 0) & ctx.is_enabled(mi.BSDFFlags.Null, 2)
        return share, dr.select(seen, total, 0)

    def sample(self, ctx, si, sample1, sample2, active=True):
        bs, weight = super().sample(ctx, si, sample1, sample2, active)
        if not self._unseen:
            return bs, weight
        share, total = self._straight(ctx, si, active)
        straight = sample1 >= 1 - share  # the other parts have the shares below it
        passes = straight & dr.any(total > 0)
        bs.wo = dr.select(straight, -si.wi, bs.wo)
        bs.pdf = dr.select(straight, dr.select(passes, share, 0), bs.pdf)
        bs.eta = dr.select(straight, 1, bs.eta)
        bs.sampled_type = dr.select(straight, mi.UInt32(+mi.BSDFFlags.Null), bs.sampled_type)
        bs.sampled_component = dr.select(straight, mi.UInt32(2), bs.sampled_component)
        return bs, dr.select(
            passes, total / dr.maximum(share, 1e-6), dr.select(straight, 0, weight)
        )

    def eval_null_transmission(self, si, active=True):
        return self._straight(mi.BSDFContext(), si, active)[1]

    def traverse(self, callback):
        names = [*SHARES]
        for layer in (*self._layers, *self._unseen):
            names += layer.bsdf.names
        if "transmission_color" in names:  # a coat may appear
            names += ("coat_weight", *OF_COAT)
        self._inputs.traverse(callback, dict.fromkeys(names), self._fixed())

    def _fixed(self) -> set[str]:
        """The parameters by which a part has no derivatives."""
        return {name for layer in self._layers for name in layer.bsdf.fixed}

    def _update(self, keys):
        changed = {*keys}
        for name in sorted(self._fixed()):
            if has_gradients(self._inputs.textures[name]):
                raise ParameterError(
                    f"{self._inputs.where}: {name} carries gradients, but panes and coats on what "
                    "transmits light have derivatives by transmission_color and coat_color alone, "
                    "and by walks or of spectra none; disable them"
                )
        if self._inputs.refresh() or index_of(self._inputs) != self._ior:
            self._configure()
        else:
            for layer in self._layers:
                if not changed or not changed.isdisjoint(layer.bsdf.names):
                    layer.bsdf.parameters_changed(list(keys))
