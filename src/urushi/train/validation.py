"""Figures of E and P on the validation parts, for the log and for the weights' header."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from urushi.checks import CoatParameters
from urushi.core import error_metrics
from urushi.nets import lobe as lobes
from urushi.nets.architecture import Architecture
from urushi.nets.decoder import decode
from urushi.nets.encoder import encode
from urushi.nets.features import direction_features
from urushi.nets.layerer import layer
from urushi.nets.mlp import Params
from urushi.train.data.store import Store
from urushi.train.examples import METRICS, coats_to_layer, encoder_inputs, top_lobes


@dataclass(frozen=True)
class Check:
    """One validation part in memory: the arrays of `examples.Examples`, and the pairs' cosines."""

    metric: str
    lobes: np.ndarray
    probes: np.ndarray
    coats: np.ndarray
    features: np.ndarray
    top: np.ndarray
    f: np.ndarray
    cos_i: np.ndarray
    cos_o: np.ndarray


def load(store: Store, arch: Architecture) -> list[Check]:
    """Read the validation parts of a store."""
    checks = []
    for part in store.spec.parts:
        if part.directions not in METRICS:
            continue
        arrays = store.read(part)
        wi, wo = arrays["wi"], arrays["wo"]
        own, rest = encoder_inputs(part, arrays, arch)
        checks.append(
            Check(
                metric=METRICS[part.directions],
                lobes=own,
                probes=rest,
                coats=coats_to_layer(part, arrays),
                features=direction_features(wi, wo, arch.widths),
                top=lobes.f(top_lobes(part, arrays, arch)[:, None], wi, wo),
                f=arrays["f"],
                cos_i=wi[..., 2],
                cos_o=wo[..., 2],
            )
        )
    return checks


def measure(params: Params, arch: Architecture, checks: list[Check]) -> dict[str, float]:
    """E mean and P median, as fractions; they include the noise of the reference."""
    host: dict[str, Any] = {name: np.asarray(value) for name, value in params.items()}
    figures = {}
    for check in checks:
        z = np.concatenate([check.lobes, encode(host, arch, check.probes)], axis=-1)
        for coat in np.moveaxis(check.coats, 1, 0)[::-1]:  # the lowest first
            z = layer(host, arch, z, CoatParameters.of_columns(coat.T))
        f_hat = check.top + decode(host, arch, z[:, None, arch.lobe :], check.features)
        if check.metric == "E mean":
            errors = error_metrics.stack_error(f_hat, check.f, check.cos_i, check.cos_o)
            figures[check.metric] = float(errors.mean())
        else:
            figures[check.metric] = float(np.median(error_metrics.pair_error(f_hat, check.f)))
    return figures
