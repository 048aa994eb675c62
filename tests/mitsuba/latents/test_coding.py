"""Derivatives of layering and encoding, where the limit of energy acts and where it does not."""

import drjit as dr
import numpy as np
import pytest
from tests.untrained import untrained

from urushi.checks import CoatParameters, Widths
from urushi.material import energy
from urushi.material.energy import limit_albedo
from urushi.material.values import codes_of
from urushi.nets import layerer
from urushi.nets import lobe as lobes
from urushi.nets.weights import Model

ROWS = 24

#: Ranges of coats, and of their changes.
LOW, HIGH = [0.1, 1.2, 0.5, 0.1, -0.3, 0.1], [0.6, 2, 0.9, 1, 0.5, 0.6]
CHANGES = np.array([0.1, 0.1, 0.1, 0.03, 0.1, 0.1])


def make_model(widths: int, gain: float, crossing: int = 0) -> Model:
    """Networks whose layerer changes gains by a number: above 0 they gain energy."""
    model = untrained(3, widths=widths, crossing=crossing)
    params = dict(model.params)
    last = f"layerer.{len(model.arch.layerer)}.bias"
    params[last] = params[last] + gain * (np.arange(len(params[last])) == 0)
    return Model.of(model.arch, params, {})


@pytest.fixture(scope="module")
def gaining() -> Model:
    return make_model(1, 0.0)


def drawn_lobes(rng, widths: int) -> np.ndarray:
    """Lobes of dielectrics (N, 6 or 7) of any index, and of metals."""
    zero, one = np.zeros(ROWS), np.ones(ROWS)
    metal = np.arange(ROWS) % 2 == 0
    width = rng.uniform(0.1, 0.6, (2, ROWS))
    eta, k = np.where(metal, 0.5, rng.uniform(0.6, 2.5, ROWS)), np.where(metal, 3.0, 0)
    return np.stack([width[0], zero, zero, one, eta, k, width[1]], axis=-1)[:, : 5 + widths]


def inputs(model: Model) -> tuple[np.ndarray, ...]:
    """Codes, coats and changes of both, float64."""
    rng, widths = np.random.default_rng(0), model.widths
    rest = 0.3 * rng.normal(size=(ROWS, model.arch.latent - model.arch.lobe))
    z = np.concatenate([drawn_lobes(rng, widths), rest], axis=-1).astype(np.float32)
    coat = rng.uniform(LOW, HIGH, (ROWS, 6))[:, : 4 + widths].astype(np.float32)
    dz = rng.normal(size=z.shape) * 0.1
    dz[:, 1 : model.arch.lobe] *= 0.1
    dz[:, 5] = 0  # k is one-sided at zero
    dcoat = rng.normal(size=coat.shape) * CHANGES[: 4 + widths]
    return z, coat, dz, dcoat


def layered(mi, model: Model, z: np.ndarray, coat: np.ndarray):
    """The coated codes (N, 1, L), the bottoms' codes and the coats, as Dr.Jit arrays."""
    from urushi.mitsuba.latents import coding

    parameters = CoatParameters.of_columns(coat.T.astype(np.float64)[..., None])
    bottom = mi.TensorXf(np.ascontiguousarray(z[:, None], np.float32))
    columns = [mi.Float(np.ascontiguousarray(column, np.float32)) for column in coat.T]
    dr.enable_grad(bottom, columns)
    each = [[column] for column in columns]
    return coding.layered(model, parameters, bottom, each), bottom, columns


def pushed(mi, model, z, coat, dz, dcoat) -> np.ndarray:
    """The change (N, L) of coated codes."""
    coated, bottom, columns = layered(mi, model, z, coat)
    dr.set_grad(bottom, mi.TensorXf(np.ascontiguousarray(dz[:, None], np.float32)))
    for column, change in zip(columns, dcoat.T, strict=True):
        dr.set_grad(column, mi.Float(np.ascontiguousarray(change, np.float32)))
    return dr.forward_to(coated).numpy()[:, 0]


def pulled(mi, model, z, coat, weights) -> tuple[np.ndarray, np.ndarray]:
    """Gradients (N, L) and (N, C) of the sum of the weighted coated codes."""
    coated, bottom, columns = layered(mi, model, z, coat)
    dr.backward(dr.sum(coated.array * mi.Float(weights.ravel().astype(np.float32))))
    of_coat = [dr.grad(column).numpy() for column in columns]
    return dr.grad(bottom).numpy()[:, 0], np.stack(of_coat, axis=-1)


def differences(model, z, coat, dz, dcoat, step=1e-3, limited=True) -> np.ndarray:
    """Central differences (N, L) of coated codes, by the networks in double precision."""
    double = {name: value.astype(np.float64) for name, value in model.params.items()}
    ends = []
    for way in (step, -step):
        parameters = CoatParameters.of_columns((coat + way * dcoat).T)
        crossing = model.networks.crossing
        codes = layerer.layer(double, model.arch, z + way * dz, parameters, crossing)
        ends.append(limit_albedo(model, codes.astype(np.float32)) if limited else codes)
    return (ends[0] - ends[1]) / (2 * step)


@pytest.mark.parametrize(("widths", "crossing"), ((1, 0), (1, 40), (2, 0)))
def test_layering_against_differences(rgb, widths, crossing):
    """Where nothing is limited, to single precision."""
    model = make_model(widths, -20.0, crossing)
    values = tuple(x.astype(np.float64) for x in inputs(model))
    expected = differences(model, *values, 1e-6, limited=False)
    np.testing.assert_allclose(pushed(rgb, model, *values), expected, rtol=2e-3, atol=1e-4)


def test_limited_codes_against_differences(rgb, gaining):
    """To 2 %: single precision, and the table of lobes' albedos is interpolated linearly.

    Another direction may become the one with the largest albedo within a step: rows may differ.
    """
    z, coat, dz, dcoat = inputs(gaining)
    unlimited = gaining.networks.layer(z, CoatParameters.of_columns(coat.T))
    over = limit_albedo(gaining, unlimited)[:, 6] < unlimited[:, 6] - 1e-4
    assert 0 < over.sum() < ROWS
    expected = differences(gaining, z, coat, dz, dcoat)
    error = np.abs(pushed(rgb, gaining, z, coat, dz, dcoat) - expected).max(axis=-1)
    assert np.sort(error / np.abs(expected).max(axis=-1))[-4] < 2e-2


def test_the_limit_follows_the_lobe(gaining):
    """More reflection at the interface leaves less for the rest, whatever the network says."""
    z, coat, *_ = inputs(gaining)
    for row in limit_albedo(gaining, gaining.networks.layer(z, CoatParameters.of_columns(coat.T))):
        of_z = energy.factor_slopes(gaining, row)
        assert of_z[4] < 0  # eta above one reflects more
        assert of_z[6] == pytest.approx(-1, abs=1e-3)  # the gain is given back


@pytest.mark.parametrize(("widths", "crossing"), ((1, 0), (1, 40), (2, 0)))
def test_backward_is_the_transpose_of_forward(rgb, widths, crossing):
    """<u, J v> = <J^T u, v>, to single precision."""
    model = make_model(widths, 1.5, crossing)
    z, coat, dz, dcoat = inputs(model)
    u = np.random.default_rng(2).normal(size=z.shape)
    forward = u * pushed(rgb, model, z, coat, dz, dcoat)
    of_z, of_coat = pulled(rgb, model, z, coat, u)
    backward = (of_z * dz).sum(axis=-1) + (of_coat * dcoat).sum(axis=-1)
    size = np.abs(forward).sum(axis=-1)
    np.testing.assert_allclose((forward.sum(axis=-1) - backward) / size, 0, atol=1e-4)


def test_the_width_of_no_interface_has_no_derivative(rgb, gaining):
    z, coat, *_ = inputs(gaining)
    coat[:, 1] = 1
    _, of_coat = pulled(rgb, gaining, z, coat, np.ones_like(z))
    assert not of_coat[:, 0].any() and np.isfinite(of_coat).all() and of_coat[:, 3].any()


def test_absent_coats_pass_the_change_of_the_bottom(rgb, gaining):
    z, coat, dz, dcoat = inputs(gaining)
    coat[:, 1], coat[:, 3] = 1, 0
    np.testing.assert_allclose(pushed(rgb, gaining, z, coat, dz, dcoat), dz, rtol=1e-5)


def test_white_media_have_finite_derivatives(rgb, gaining):
    z, coat, *_ = inputs(gaining)
    coat[:, 2] = 1
    for gradient in pulled(rgb, gaining, z, coat, np.ones_like(z)):
        assert np.isfinite(gradient).all()


def glossy(model: Model) -> tuple[np.ndarray, np.ndarray]:
    """Values (N, P) of diffuse surfaces under lobes with Schlick's term, and these lobes."""
    rng = np.random.default_rng(0)
    lobe = np.tile(np.array(lobes.no_lobe(model.widths)), (ROWS, 1))
    lobe[:, :3] = rng.uniform([0.2, 0.1, 0.2], [0.6, 0.5, 0.9], (ROWS, 3))
    lobe[:, 6:] = lobe[:, :1]
    pairs = [w.astype(np.float64) for w in model.networks.pairs()]
    reflectance = np.linspace(0.1, 0.6, ROWS)[:, None]
    return lobes.f(lobe[:, None], *pairs) + reflectance / np.pi, lobe


@pytest.mark.parametrize("fitted", (False, True))
@pytest.mark.parametrize("widths", (1, 2))
def test_encoding_against_differences(rgb, widths, fitted):
    """The slope of the codes by the diffuse term, and its transpose.

    Only that term changes: a lobe would be fitted anew, and a fit ends some thousandths before its
    minimum.
    """
    from urushi.mitsuba.latents import coding

    model = make_model(widths, 0.0)
    f, lobe = glossy(model)
    known = None if fitted else lobe.astype(np.float32)

    def codes(share: float) -> np.ndarray:
        return codes_of(model, (f + share / np.pi).astype(np.float32), known)

    step = 0.01
    expected = (codes(step) - codes(-step)) / (2 * step)
    values = rgb.Float(f.astype(np.float32).ravel())
    dr.enable_grad(values)
    tensor = None if fitted else rgb.TensorXf(known[:, None])
    result = coding.encoded(model, [values], tensor, codes(0)[:, None])
    np.testing.assert_allclose(result.numpy()[:, 0], codes(0), atol=1e-5)
    u = np.random.default_rng(1).normal(size=expected.shape).astype(np.float32)
    dr.set_grad(values, 1 / np.pi)
    found = dr.forward_to(result, flags=dr.ADFlag.ClearInterior).numpy()[:, 0]
    rest = slice(model.arch.lobe, None)
    scale = np.abs(expected[:, rest]).max()
    assert np.median(np.abs(found - expected)[:, rest]) < 0.01 * scale
    dr.set_grad(values, 0)
    dr.set_grad(result, 0)
    dr.backward(dr.sum(result.array * rgb.Float(u.ravel())))
    each = dr.grad(values).numpy().reshape(f.shape) / np.pi
    error = (u * found).sum(axis=-1) - each.sum(axis=-1)
    np.testing.assert_allclose(error / np.abs(each).sum(axis=-1), 0, atol=1e-4)


def test_black_brdfs_have_finite_derivatives(rgb, gaining):
    """They are those of a dark diffuse surface."""
    from urushi.mitsuba.latents import coding

    pairs = gaining.arch.probes
    black = rgb.Float(np.zeros(pairs, np.float32))
    dr.enable_grad(black)
    none = np.array(lobes.NO_LOBE, np.float32)
    codes = codes_of(gaining, np.zeros((1, pairs), np.float32), none)[None]
    result = coding.encoded(gaining, [black], rgb.TensorXf(none[None, None]), codes)
    dr.backward(dr.sum(result.array))
    gradient = dr.grad(black).numpy()
    assert np.isfinite(gradient).all() and gradient.any()


def test_equal_widths_may_be_given_as_one(rgb):
    from urushi.mitsuba.latents import coding

    model = make_model(2, 0.0)
    z, coat, *_ = inputs(model)
    parameters = CoatParameters(*coat.T[:5, :, None].astype(np.float64))
    columns = [[rgb.Float(np.ascontiguousarray(x))] for x in (*coat.T[:5], coat[:, 0])]
    bottom = rgb.TensorXf(np.ascontiguousarray(z[:, None]))
    two = parameters._replace(alpha=Widths(parameters.alpha, parameters.alpha))
    found = [coding.layered(model, p, bottom, columns).numpy() for p in (parameters, two)]
    np.testing.assert_array_equal(*found)
