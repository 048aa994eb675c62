"""Figures of E and P on the validation parts, for the log and for the weights' header."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from urushi.data.store import Store
from urushi.geometry import error_metrics
from urushi.nets.architecture import Architecture
from urushi.nets.decoder import decode
from urushi.nets.encoder import encode
from urushi.nets.features import coat_features, direction_features
from urushi.nets.layerer import layer
from urushi.nets.mlp import Params
from urushi.train.examples import METRICS, bottom_values, coats_to_layer


@dataclass(frozen=True)
class Check:
    """One validation part in memory: the arrays of `examples.Examples`, and the pairs' cosines."""

    metric: str
    probes: np.ndarray
    coats: np.ndarray
    features: np.ndarray
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
        checks.append(
            Check(
                metric=METRICS[part.directions],
                probes=bottom_values(part, arrays["bottom"], arch),
                coats=coats_to_layer(part, arrays),
                features=direction_features(wi, wo),
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
        z = encode(host, arch, check.probes)
        for coat in np.moveaxis(check.coats, 1, 0)[::-1]:  # the lowest first
            z = layer(host, arch, z, coat_features(*coat.T))
        f_hat = decode(host, arch, z[:, None], check.features)
        if check.metric == "E mean":
            errors = error_metrics.stack_error(f_hat, check.f, check.cos_i, check.cos_o)
            figures[check.metric] = float(errors.mean())
        else:
            figures[check.metric] = float(np.median(error_metrics.pair_error(f_hat, check.f)))
    return figures
