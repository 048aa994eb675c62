"""Decoder terms fitted to measured BRDFs: `python -m benchmarks.quality.measured_terms FILE...`.

A code enters the decoder as a gain, and as scales and offsets of its first layer. Rendering a
constant material needs these alone. How much closer does a material come if it stores them, fitted
freely, instead of a code? And if it has further terms of its own? For every FILE, E [%] of the
refined material, and of fits of

- A: gain, scales and offsets;
- B: these and the offsets of the second layer;
- C: these and the weights of the output;
- D: as C, with a first layer of its own.

The decoder must have two hidden layers. A fit starts at the refined code and sees 1,500 pairs of
cosine density and 2,500 training pairs; E is measured at 6,000 others. Channels are fitted by
themselves, with the code's lobe. On one core, A to C take a second a channel, D takes five.
"""

import argparse
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from urushi.errors import UrushiWarning
from urushi.geometry.direction_sets import cosine_pairs, training_pairs
from urushi.geometry.error_metrics import DARK_OFFSET, energy_weight, stack_error
from urushi.material import encode
from urushi.material.encode import evaluate_source
from urushi.measured import load_measured
from urushi.nets.decoder import MAX_LOG, MIN_LOG
from urushi.nets.features import direction_features
from urushi.nets.least_squares import damped_step
from urushi.nets.mlp import with_slope
from urushi.nets.weights import find

#: The terms of each fit.
FITS = {
    "A": ("gain", "scale", "offset"),
    "B": ("gain", "scale", "offset", "second_offset"),
    "C": ("gain", "scale", "offset", "second_offset", "output"),
    "D": ("gain", "first", "offset", "second_offset", "output"),
}

COSINE_PAIRS, TRAINING_PAIRS, TEST_PAIRS = 1500, 2500, 6000

#: Share of the cosine pairs in the error, exponent of the light of a pair in its weight, and the
#: relative error from which errors count linearly.
COSINE_SHARE, POWER, KNEE = 0.6, 0.5, 0.2

STEPS, FIRST_DAMPING, DECREASE, INCREASE, GREATEST_DAMPING = 80, 1e-3, 0.3, 5.0, 1e6

Terms = dict[str, np.ndarray]


def terms_of_code(params: Any, z: np.ndarray) -> Terms:
    """The terms of a code (R,) without its lobe, float64."""
    weight, numbers = params["decoder.0.weight"].astype(np.float64), z[1:].astype(np.float64)
    return {
        "gain": np.array([z[0] + params["decoder.2.bias"][0]], np.float64),
        "scale": 1 + numbers @ params["decoder.scale"],
        "offset": numbers @ weight[: len(numbers)] + params["decoder.0.bias"],
        "first": weight[len(numbers) :],
        "second": params["decoder.1.weight"].astype(np.float64),
        "second_offset": params["decoder.1.bias"].astype(np.float64),
        "output": params["decoder.2.weight"][:, 0].astype(np.float64),
    }


def decode(terms: Terms, features: np.ndarray, activation: str, names: tuple[str, ...]) -> Any:
    """ln f (N,), and its derivatives (N, K) by the terms of these names, one after the other."""
    response = features @ terms["first"]
    h, slope = with_slope(terms["offset"] + terms["scale"] * response, activation)
    last, last_slope = with_slope(h @ terms["second"] + terms["second_offset"], activation)
    inner = terms["output"] * last_slope
    outer = (inner @ terms["second"].T) * slope
    derivatives: dict[str, Callable[[], np.ndarray]] = {
        "gain": lambda: np.ones((len(h), 1)),
        "scale": lambda: outer * response,
        "offset": lambda: outer,
        "first": lambda: (features[:, :, None] * (outer * terms["scale"])[:, None]).reshape(
            len(h), -1
        ),
        "second_offset": lambda: inner,
        "output": lambda: last,
    }
    log_f = np.clip(terms["gain"] + last @ terms["output"], MIN_LOG, MAX_LOG)
    return log_f, np.concatenate([derivatives[name]() for name in names], axis=1)


def fit(
    terms: Terms,
    names: tuple[str, ...],
    features: np.ndarray,
    top: np.ndarray,
    f: np.ndarray,
    weights: np.ndarray,
    activation: str,
) -> Terms:
    """Terms whose values, added to `top` (N,), are closer to f (N,), by damped steps."""

    def state(terms: Terms) -> tuple[float, np.ndarray, np.ndarray]:
        log_rest, slopes = decode(terms, features, activation, names)
        rest = np.exp(log_rest)
        error = np.log((top + rest + DARK_OFFSET) / (f + DARK_OFFSET))
        slopes *= (rest / (top + rest + DARK_OFFSET))[:, None]
        far = np.maximum(np.abs(error) / KNEE, 1)
        weighted = slopes.T * (weights / far)
        loss = (weights * error**2 * (2 - 1 / far) / far).sum()
        return float(loss), weighted @ slopes, weighted @ error

    found, damping = state(terms), FIRST_DAMPING
    for _ in range(STEPS):
        step, start, moved = damped_step(found[1], found[2], damping), 0, dict(terms)
        for name in names:
            size = terms[name].size
            moved[name] = terms[name] - step[start : start + size].reshape(terms[name].shape)
            start += size
        new = state(moved)
        if new[0] < found[0]:
            terms, found, damping = moved, new, damping * DECREASE
        else:
            damping *= INCREASE
        if damping > GREATEST_DAMPING:
            break
    return terms


def errors(path: Path, weights: str | None, fits: list[str]) -> list[float]:
    """E [%] of the refined material of a file and of each of the fits."""
    model, source, rng = find(weights), load_measured(path), np.random.default_rng(0)
    seen = [
        np.concatenate(sides).astype(np.float32)
        for sides in zip(
            cosine_pairs(rng, COSINE_PAIRS), training_pairs(rng, TRAINING_PAIRS), strict=True
        )
    ]
    unseen = [w.astype(np.float32) for w in cosine_pairs(np.random.default_rng(9), TEST_PAIRS)]
    f, expected = (evaluate_source(source, *pairs).values for pairs in (seen, unseen))
    cosines = unseen[0][:, 2], unseen[1][:, 2]
    material = encode(source, model)
    features = [direction_features(*pairs).astype(np.float64) for pairs in (seen, unseen)]
    light = energy_weight(seen[0][:COSINE_PAIRS, 2], seen[1][:COSINE_PAIRS, 2])[:, None]
    result = [float(stack_error(material.f(*unseen).T, expected.T, *cosines).mean())]
    for name in fits:
        made = np.empty(expected.shape)
        for channel, z in enumerate(material.latents):
            share = (f[:COSINE_PAIRS, channel] * light[:, 0]) ** POWER
            even = np.full(TRAINING_PAIRS, (1 - COSINE_SHARE) / TRAINING_PAIRS)
            of_pairs = np.concatenate([COSINE_SHARE * share / share.sum(), even])
            tops = [model.networks.top(z, *pairs) for pairs in (seen, unseen)]
            start = terms_of_code(model.params, z[model.arch.lobe :])
            if "first" in FITS[name]:
                start |= {"first": start["first"] * start["scale"], "scale": np.ones(1)}
            terms = fit(
                start,
                FITS[name],
                features[0],
                tops[0],
                f[:, channel].astype(np.float64),
                of_pairs,
                model.arch.activation,
            )
            log_rest, _ = decode(terms, features[1], model.arch.activation, ("gain",))
            made[:, channel] = tops[1] + np.exp(log_rest)
        result.append(float(stack_error(made.T, expected.T, *cosines).mean()))
    return [100 * e for e in result]


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.quality.measured_terms",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("files", type=Path, nargs="+")
    parser.add_argument("--weights", help="networks: a name or file; default: the default ones")
    parser.add_argument("--fits", nargs="+", choices=FITS, default=list(FITS))
    options = parser.parse_args()
    warnings.simplefilter("ignore", UrushiWarning)
    rows = []
    for path in options.files:
        rows.append(errors(path, options.weights, options.fits))
        print(f"{path.stem:28s}", *(f"{e:6.1f}" for e in rows[-1]), flush=True)
    print(f"{'mean':28s}", *(f"{e:6.1f}" for e in np.mean(rows, axis=0)))


if __name__ == "__main__":
    main()
