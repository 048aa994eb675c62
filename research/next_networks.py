"""Short trainings that compare forms of the next networks: `python -m research.next_networks`.

    python -m research.next_networks data 0.06 out/trial   simulate training data and test stacks
    python -m research.next_networks train FORM out/trial --steps 3072
    python -m research.next_networks measure WEIGHTS out/trial

A form (`FORMS`) says what is trained. A code has the numbers of the topmost lobe, three of an inner
lobe, one gain for each output of the decoder, and the other numbers. The inner lobe is the bottom's
as it is seen through the coats, in closed form (`through`, `inner_f`); the decoder multiplies it by
a factor and adds the rest. Where `terms` is set, the other numbers of a code are the offsets and
factors of the decoder's first layer themselves, so that no product turns a code into terms.

The last command measures complete networks, a file or the name of shipped ones, on the test stacks:
their codes as they are, and with the limits of energy that `layer` has.

Every 1,024 steps a line gives E in per cent (mean / median / 95th percentile) of test stacks that
were drawn with another seed, with the noise of their 2,048 walks.
"""

import argparse
import itertools
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from urushi.checks import CoatParameters
from urushi.core import error_metrics
from urushi.core.probe_pairs import PROBES, probe_pairs
from urushi.material.layer import layer_texels
from urushi.nets import lobe as lobes
from urushi.nets import weights
from urushi.nets.architecture import Architecture
from urushi.nets.encoder import encode, input_statistics
from urushi.nets.features import COAT_FEATURES, DIRECTION_TABLE, coat_features, direction_features
from urushi.nets.lobe import LOBE_FEATURES, lobe_features, of_coat
from urushi.nets.mlp import activate, hidden_to_output, linear, product, split_linear
from urushi.nets.weights import Model
from urushi.train import examples, losses
from urushi.train.batches import batches
from urushi.train.distribution import Extended, Practical
from urushi.train.examples import bottom_lobes
from urushi.train.losses import bounded, columns_of, pair_weights, stack_loss
from urushi.train.optimiser import Schedule, compile_steps, start
from urushi.train.presets import validation, whole_domain
from urushi.train.store import DataSpec, Part, Store, generate

#: The kinds of bottoms of practical stacks, and thousands of training stacks by number of coats.
KINDS = ("conductor", "conductor_complex", "dielectric", "diffuse", "mixture", "measured_like")
THOUSANDS = {1: (128, 96, 24, 64, 96, 32), 2: (64, 48, 16, 48, 64, 24), 3: (16, 12, 4, 12, 16, 6)}

#: Test stacks by number of coats: of practical stacks, and of the whole domain.
PRACTICAL = dict.fromkeys((1, 2, 3), (24, 16, 6, 14, 16, 8))
WHOLE = dict.fromkeys((1, 2, 4), (16, 12, 8, 14, 16, 8))

ACTIVATION = "silu7"

#: Numbers of the topmost lobe and of the inner one: width, index of the medium relative to air, and
#: reflectance with the light that the media absorb; those of no inner lobe.
TOP, INNER = 6, 3
NO_INNER = np.array([1.0, 1.0, 0.0], np.float32)


@dataclass(frozen=True)
class Form:
    """What is trained.

    Attributes:
        inner: whether the decoder multiplies the inner lobe.
        terms: whether a code is the terms of the decoder's first layer.
        energy: share of pairs' weights that follow their energy in the error E.
        rest: other numbers of a code, without gains, unless they are terms.
        decoder, layerer: widths of hidden layers.
    """

    inner: bool = False
    terms: bool = False
    energy: float = 0.9
    rest: int = 17
    decoder: tuple[int, ...] = (16, 16)
    layerer: tuple[int, ...] = (224, 224, 224)
    encoder: tuple[int, ...] = (256, 256)

    @property
    def gains(self) -> int:
        """Outputs of the decoder, which each have a gain in the code."""
        return 1 + self.inner

    @property
    def size(self) -> int:
        """Numbers of a code without those of its lobes."""
        return self.gains + (2 * self.decoder[0] if self.terms else self.rest)


FORMS = {
    "base": Form(energy=0.0),
    "energy": Form(),
    "inner": Form(inner=True),
    "terms": Form(terms=True),
    "all": Form(inner=True, terms=True),
    "wide": Form(inner=True, terms=True, decoder=(24, 24)),
}


def data(share: float) -> DataSpec:
    """Training stacks: a share of the whole domain's, and about as many practical ones."""
    whole = [p for p in whole_domain(0.7 * share).parts if not p.name.startswith("validation")]
    practical = [
        Part(f"practical-{kind}-{coats}", Practical(coats, kind), round(1024 * n * share), 128, 64)
        for coats, thousands in THOUSANDS.items()
        for kind, n in zip(KINDS, thousands, strict=True)
    ]
    return DataSpec((*whole, *practical, *validation()), seed=1, shard=1024)


def tests() -> DataSpec:
    """Test stacks of another seed, at pairs of cosine density."""
    parts = []
    for name, counts in (("practical", PRACTICAL), ("whole", WHOLE)):
        for coats, numbers in counts.items():
            for kind, n in zip(KINDS, numbers, strict=True):
                drawn = Extended(coats, kind, indices="whole")
                drawn = Practical(coats, kind) if name == "practical" else drawn
                parts.append(Part(f"{name}-{kind}-{coats}", drawn, n, 256, 2048, "cosine"))
    parts += [
        Part(f"low-{kind}-1", Extended(1, kind, indices="low"), 12, 256, 2048, "cosine")
        for kind in ("conductor", "conductor_complex")
    ]
    return DataSpec(tuple(parts), seed=777, shard=64)


# The inner lobe


def through(coat: CoatParameters, lobe: Any, inner: Any) -> Any:
    """The inner lobe (..., 3) of a material with these lobes under a coat.

    Of the material's topmost lobe and its inner one, the one with the brighter peak remains. The
    coat's interface widens it: by the walk, squared slopes grow by 2.5 (1 - 1 / eta)^2 alpha^2.
    """
    xp = lobe.__array_namespace__()
    reflected = 0.5 * (lobes.reflectance(lobe, xp.asarray(1.0)) + lobes.reflectance(lobe, 0.5))
    width, index, strength = (inner[..., k] for k in range(INNER))
    chosen = reflected / lobe[..., 0] ** 2 >= strength / width**2
    width = xp.where(chosen, lobe[..., 0], width)
    index = xp.where(chosen, 1.0, index)
    strength = xp.where(chosen, reflected, strength)
    slope = (1 - 1 / coat.eta) / index * coat.alpha
    width = xp.sqrt(width**2 + 2.5 * slope**2).clip(0.01, 1.0)
    index = (index * coat.eta).clip(0.3, 4.0)
    return xp.stack([width, index, strength * xp.exp(-2 * coat.sigma_t)], axis=-1)


def inner_features(inner: Any) -> Any:
    """Features (..., 4) of inner lobes (..., 3) for the layerer."""
    width, index, strength = (inner[..., k] for k in range(INNER))
    seen = strength / (strength + 0.01)
    columns = (
        seen * jnp.log(width) / 1.1 + 0.8,
        seen * width / 0.3,
        seen * jnp.log(index) / 0.4,
        (jnp.log(strength + 0.01) + 3) / 1.5,
    )
    return jnp.stack(columns, axis=-1)


def inner_f(inner: Any, features: Any) -> Any:
    """The inner lobe's BRDF (...) [1/sr] without masking, at `direction_features` (..., D)."""
    width, index, strength = (inner[..., k] for k in range(INNER))
    tan2 = jnp.maximum(jnp.exp(_column(features, "ln(tan^2 theta_h + 1e-6)")) - 1e-6, 0.0)
    total = jnp.exp(_column(features, "ln(cos_i + cos_o)"))
    low = _column(features, "min(cos_i, cos_o)")
    cosines = low, jnp.clip(total - low, 5e-3, 1.0)
    squares = [1 - (1 - c * c) / index**2 for c in cosines]
    inside = [jnp.sqrt(jnp.maximum(square, 1e-6)) for square in squares]
    f = strength / (4 * math.pi * index**2)
    for outer, inner_cosine in zip(cosines, inside, strict=True):
        both = 1 / (outer + index * inner_cosine) ** 2 + 1 / (index * outer + inner_cosine) ** 2
        f = f * 2 * index * outer * inner_cosine * both  # Fresnel's transmission, unpolarised
    tan2 = tan2 * (total / (index * (inside[0] + inside[1]))) ** 2
    visible = (squares[0] > 0) & (squares[1] > 0)
    return jnp.where(visible, f * width**2 / (tan2 + width**2) ** 2, 0.0)


_COLUMNS = {name: (k, mean, scale) for k, (name, mean, scale) in enumerate(DIRECTION_TABLE)}


def _column(features: Any, name: str) -> Any:
    column, mean, scale = _COLUMNS[name]
    return features[..., column] * scale + mean


# The networks


def initial(form: Form, seed: int) -> dict[str, np.ndarray]:
    """Random parameters, as those of `architecture.init`."""
    rng, params = np.random.default_rng(seed), {}
    coat = LOBE_FEATURES[1] + 8 * form.inner + COAT_FEATURES[1]
    sizes = {
        "encoder": ((PROBES, *form.encoder, form.size), 1.0),
        "layerer": ((form.size + coat, *form.layerer, form.size), 0.1),
        "decoder": ((len(DIRECTION_TABLE), *form.decoder, form.gains), 0.3),
    }
    for name, (widths, output) in sizes.items():
        for k, (rows, columns) in enumerate(itertools.pairwise(widths)):
            gain = output if k == len(widths) - 2 else math.sqrt(2)
            weight = rng.standard_normal((rows, columns)) * gain / math.sqrt(rows)
            params[f"{name}.{k}.weight"] = weight.astype(np.float32)
            params[f"{name}.{k}.bias"] = np.zeros(columns, np.float32)
    first, count = form.decoder[0], form.size - form.gains
    if form.terms:
        params[f"encoder.{len(form.encoder)}.weight"][:, form.gains + first :] *= 0.1
    else:
        shift = rng.standard_normal((count, first)) * math.sqrt(2 / (count + 8))
        params |= {"decoder.shift": shift.astype(np.float32)}
        params |= {"decoder.scale": np.zeros((count, first), np.float32)}
    return params


def decoded(form: Form, params: Any, z: Any, features: Any) -> Any:
    """f (B, P) [1/sr] without the topmost lobe, of codes z (B, N) at features (B, P, D)."""
    z = z[:, None, TOP:]
    inner, gains = z[..., :INNER], z[..., INNER : INNER + form.gains]
    code = z[..., INNER + form.gains :]
    response = product(features, params["decoder.0.weight"])
    if form.terms:
        first = form.decoder[0]
        x = code[..., :first] + params["decoder.0.bias"] + (1 + code[..., first:]) * response
    else:
        offset = product(code, params["decoder.shift"]) + params["decoder.0.bias"]
        x = offset + (1 + product(code, params["decoder.scale"])) * response
    for k in range(1, len(form.decoder) + 1):
        x = linear(params, f"decoder.{k}", activate(x, ACTIVATION))
    x = x + gains
    f = jnp.exp(x[..., 0].clip(-25.0, 20.0))
    return f + inner_f(inner, features) * jnp.exp(x[..., 1].clip(-12, 6)) if form.inner else f


def layered(form: Form, params: Any, z: Any, columns: Any) -> Any:
    """Codes (B, N) of materials z (B, N) under coats (B, C)."""
    coat = columns_of(columns)
    lobe, inner, rest = z[:, :TOP], z[:, TOP : TOP + INNER], z[:, TOP + INNER :]
    own, below = [rest, lobe_features(lobe)], inner
    if form.inner:
        below = through(coat, lobe, inner)
        own += [inner_features(inner), inner_features(below)]
    first = split_linear(params, "layerer.0", jnp.concatenate(own, -1), coat_features(*coat))
    rest = bounded(rest + hidden_to_output(params, "layerer", first, ACTIVATION))
    return jnp.concatenate([of_coat(coat.alpha, coat.eta), below, rest], -1)


def coated(form: Form, params: Any, z: Any, coats: Sequence[Any]) -> Any:
    """Codes (B, N) under coats, the lowest first, each of the first rows alone."""
    for coat in coats:
        count = coat.shape[0]
        z = jnp.concatenate([layered(form, params, z[:count], coat), z[count:]])
    return z


def encoded(params: Any, arch: Architecture, own: Any, values: Any) -> Any:
    """Codes (B, N) of BRDFs with lobes `own` (B, 9) and other values (B, probes) [1/sr]."""
    return jnp.concatenate([own, bounded(encode(params, arch, values))], -1)


# Training


def inputs(
    part: Part, arrays: dict[str, np.ndarray], arch: Architecture, form: Form
) -> tuple[np.ndarray, np.ndarray]:
    """`examples.encoder_inputs` with the numbers of the inner lobes."""
    own, rest = _ENCODER_INPUTS(part, arrays, arch)
    inner = np.tile(NO_INNER, (len(own), 1))
    if part.directions == "probed" and form.inner:
        lobe = bottom_lobes(part.distribution.bottom, arrays["bottom"], arch)
        for columns in np.moveaxis(arrays["coats"], 1, 0)[::-1]:
            coat = CoatParameters.of_columns(columns.T)
            inner, lobe = through(coat, lobe, inner), of_coat(coat.alpha, coat.eta)
    return np.concatenate([own, inner], axis=-1, dtype=np.float32), rest


_ENCODER_INPUTS = examples.encoder_inputs


def measured(form: Form, params: Any, arch: Architecture, store: Store) -> dict[str, np.ndarray]:
    """E of all test stacks by group: the distribution and the number of coats; and of metals."""
    groups: dict[str, list[np.ndarray]] = {}

    @jax.jit
    def predicted(own: Any, rest: Any, coats: Any, features: Any, top: Any) -> Any:
        z = encoded(params, arch, own, rest)
        z = coated(form, params, z, [coats[:, k] for k in reversed(range(coats.shape[1]))])
        return top + decoded(form, params, z, features)

    for part in store.spec.parts:
        arrays = store.read(part)
        wi, wo, f = arrays["wi"], arrays["wo"], arrays["f"]
        top = lobes.f(examples.top_lobes(part, arrays, arch)[:, None], wi, wo)
        own, rest = inputs(part, arrays, arch, form)
        found = predicted(own, rest, arrays["coats"], direction_features(wi, wo), top)
        errors = error_metrics.stack_error(np.asarray(found), f, wi[..., 2], wo[..., 2])
        name, kind, coats = part.name.split("-")
        groups.setdefault(f"{name} {coats}", []).append(errors)
        if kind.startswith("conductor"):
            groups.setdefault(f"{name} {coats} metal", []).append(errors)
    return {name: np.concatenate(errors) for name, errors in groups.items()}


def train(form: Form, folder: Path, share: float, steps: int, rate: float, seed: int) -> None:
    """Train by the joint loss on `data(share)` and print the errors."""
    arch = Architecture(latent=24, decoder=form.decoder, activation=ACTIVATION)
    examples.encoder_inputs = lambda *given: inputs(*given, form)  # codes have an inner lobe
    depths = examples.load(generate(data(share), folder / "data"), arch, 64)
    fixed = input_statistics(np.concatenate([depth.examples().probes for depth in depths]))
    at_probes = jnp.asarray(direction_features(*probe_pairs()))

    def loss(trained: Any, batch: Any) -> tuple[jax.Array, dict[str, jax.Array]]:
        params = {**fixed, **trained}
        z = coated(form, params, encoded(params, arch, batch.lobes, batch.probes), batch.coats)
        f = batch.top + decoded(form, params, z, batch.features)
        fit = stack_loss(f, batch.f, pair_weights(f, batch.features, form.energy))
        some = slice(None, None, 16)
        again = decoded(form, params, z[some], at_probes[None])
        again = encoded(params, arch, z[some, : TOP + INNER], again)
        f = batch.top[some] + decoded(form, params, again, batch.features[some])
        total = fit + 0.02 * stack_loss(f, batch.f[some])
        return total, {"loss": total, "fit": fit}

    schedule = Schedule(steps=steps, warmup=256, learning_rate=rate, clip=0.1, average=0.995)
    state, run = start(initial(form, seed), schedule), compile_steps(loss, schedule)
    take = batches(depths, (48, 112, 64, 24, 7, 7), seed)
    checks, began = generate(tests(), folder / "tests"), time.process_time()
    for step in range(0, steps, schedule.steps_per_call):
        state, terms = run(state, take(step, schedule.steps_per_call))
        done = step + schedule.steps_per_call
        if done % 1024 == 0 or done == steps:
            figures = measured(form, {**fixed, **state.average}, arch, checks)
            print(f"{done} steps, {time.process_time() - began:.0f} s, loss {terms['loss']:.4f}")
            for name, errors in figures.items():
                median, p95 = np.percentile(errors, (50, 95))
                print(f"  {name:18} {100 * errors.mean():.2f} {100 * median:.2f} {100 * p95:.1f}")


def measure(model: Model, folder: Path) -> None:
    """Print E of the test stacks, layered without limits of energy and with them.

    The mean error that the noise of the walks causes is subtracted in squares, stack by stack.
    """
    groups: dict[str, list[np.ndarray]] = {}
    checks = generate(tests(), folder / "tests")
    for part in checks.spec.parts:
        name, kind, count = part.name.split("-")
        if name == "validation":
            continue
        arrays = checks.read(part)
        coats = [coat.T for coat in np.moveaxis(arrays["coats"], 1, 0)[::-1]]
        bottoms = losses.encoded(
            model.params, model.arch, *examples.encoder_inputs(part, arrays, model.arch)
        )
        free = limited = np.asarray(bottoms)
        for coat in coats:
            columns = CoatParameters.of_columns(coat)
            free = model.networks.layer(free, columns)
            limited = layer_texels(model, limited, columns)
        wi, wo, f = arrays["wi"], arrays["wo"], arrays["f"]
        weight = error_metrics.energy_weight(wi[..., 2], wo[..., 2])
        energy = (f * weight).sum(axis=-1)
        noise = math.sqrt(2 / math.pi) * (arrays["se"] * weight).sum(axis=-1) / energy
        errors = [
            (np.abs(model.networks.f(z[:, None], wi, wo) - f) * weight).sum(axis=-1) / energy
            for z in (free, limited)
        ]
        found = np.sqrt(np.maximum(np.square(errors) - noise**2, 0))
        for group in (f"{name} {count}", f"{name} {count} {kind}"):
            groups.setdefault(group, []).append(found)
    for group in sorted(groups):
        found = 100 * np.concatenate(groups[group], axis=-1)
        median, p95 = np.percentile(found, (50, 95), axis=-1)
        numbers = zip(found.mean(axis=-1), median, p95, strict=True)
        print(f"{group:32}", *(f"{a:6.2f} {b:6.2f} {c:6.1f}" for a, b, c in numbers))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    of_data = commands.add_parser("data")
    of_data.add_argument("share", type=float, help="of the numbers of stacks in a full training")
    of_networks = commands.add_parser("measure")
    of_networks.add_argument("weights")
    of_training = commands.add_parser("train")
    of_training.add_argument("form", choices=FORMS)
    of_training.add_argument("share", type=float, help="as of data")
    for command in (of_data, of_networks, of_training):
        command.add_argument("folder", type=Path)
    of_training.add_argument("--steps", type=int, default=3072)
    of_training.add_argument("--rate", type=float, default=0.016)
    of_training.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    if given.command == "data":
        given.folder.mkdir(parents=True, exist_ok=True)
        generate(data(given.share), given.folder / "data")
        generate(tests(), given.folder / "tests")
    elif given.command == "measure":
        measure(weights.find(given.weights), given.folder)
    else:
        train(FORMS[given.form], given.folder, given.share, given.steps, given.rate, given.seed)


if __name__ == "__main__":
    main()
