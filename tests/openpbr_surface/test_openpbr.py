"""The plugin `openpbr`: the base in closed form, its coat against the walk, film, fuzz, frames."""

from unittest.mock import Mock

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from tests.mitsuba.probes import bitmap, evaluated, nearly, sampled, spheres, strip
from tests.openpbr_surface.probes import WALKS, error, loaded, pairs, toward, values
from tests.oracles.analog import analog_albedo
from tests.oracles.slab import interface_reflectance

import urushi
from urushi.core import fresnel
from urushi.core.namespace import NUMPY
from urushi.material import adding
from urushi.mitsuba.reading import probing
from urushi.nets import lobe as lobes
from urushi.openpbr_surface import formulas, thin_film
from urushi.openpbr_surface.inputs import Inputs, clipped

pytestmark = pytest.mark.usefixtures("rgb")

COLOR = (0.2, 0.5, 0.8)
BRUSHED = dict(base_metalness=1.0, specular_roughness=0.5, specular_roughness_anisotropy=0.7)


@pytest.mark.parametrize("index", [1.002, 1.1, 1.5])
def test_a_smooth_coat_over_a_polished_metal_reflects_as_many_photons(index):
    """Coat and metal have an alpha of 0.01. Photons err by 0.1 %, tables by up to 2.5 % there."""
    metal = dict(base_metalness=1.0, base_color=(0.8,) * 3, specular_roughness=0.1)
    coated = loaded(**metal, coat_weight=1.0, coat_ior=index, coat_roughness=0.0)
    cosines = np.array([0.95, 0.6, 0.3])
    found = adding.albedos(lambda wi, wo: values(coated, wi, wo), cosines)
    wi = np.stack([np.sqrt(1 - cosines**2), 0 * cosines, cosines], axis=1).astype(np.float32)
    stack = urushi.coat(urushi.conductor(0.01, r0=0.8), 0.01, ior=index)
    photons, _ = analog_albedo(stack, wi, walks=1 << 17)
    np.testing.assert_allclose(found, photons, rtol=0.03)


def test_fuzz_seen_along_the_normal_is_the_limit_of_small_angles():
    """The normal has no azimuth. The fuzz is continuous: 1e-4 rad change f by 1e-3 at most."""
    bsdf, wo = loaded(fuzz_weight=1.0), pairs(200)[1]
    seen = [values(bsdf, np.tile(np.float32([x, 0, 1]), (200, 1)), wo) for x in (0, 1e-7, 1e-4)]
    np.testing.assert_allclose(seen[0], seen[1], rtol=1e-3)
    np.testing.assert_allclose(seen[0], seen[2], rtol=1e-3)


def test_a_film_changes_the_fresnel_term_of_metals_and_dielectrics():
    """At the mirror direction f is that without film, times the quotient of the reflectances."""
    film = {"thin_film_weight": 1.0, "thin_film_thickness": 0.3, "thin_film_ior": 1.8}
    cosine, f0 = 0.6, np.array([0.2, 0.5, 0.8])
    wi = np.float32([[0.8, 0, cosine]])
    for metalness, below in (
        (1.0, [thin_film.metal_index(x, np.float64(1)) for x in f0]),
        (0.0, [thin_film.Below(np.float64(1.5))] * 3),
    ):
        shared = dict(base_color=COLOR, base_metalness=metalness, specular_roughness=0.1)
        if not metalness:
            shared["base_weight"] = 0.0  # the interface alone
        seen = values(loaded(**shared, **film), wi, wi * [-1, 1, 1])
        bare = values(loaded(**shared), wi, wi * [-1, 1, 1])
        layer = thin_film.Film(1.8, 1.8, 0.3)
        expected = [
            thin_film.reflectance(cosine, layer, x, response)
            for x, response in zip(below, thin_film.RGB, strict=True)
        ]
        plain = fresnel.f82(cosine, f0, 1.0) if metalness else interface_reflectance(cosine, 1.5)
        assert np.allclose(seen / bare, np.array(expected) / plain, rtol=2e-3)


@pytest.mark.slow
def test_the_coats_weight_mixes_brdfs():
    """A metal does not depend on the index above it: the mixture is exact; none is the base."""
    wi, wo = pairs(200)
    shared = dict(base_color=COLOR, base_metalness=1.0)
    base, none, half, full = (
        values(loaded(**shared, **coat), wi, wo)
        for coat in ({}, *(dict(coat_weight=x, coat_roughness=0.4) for x in (0.0, 0.25, 1.0)))
    )
    assert np.array_equal(none, base)
    assert np.allclose(half, 0.75 * base + 0.25 * full, rtol=1e-4, atol=1e-6)


def test_the_reference_over_a_metal_is_the_walk():
    shared = dict(base_color=COLOR, base_metalness=1.0, specular_roughness=0.2, coat_weight=1.0)
    shared |= dict(coat_roughness=0.3, coat_color=COLOR, energy_compensation=False)
    wi, wo = pairs(300)
    stack = urushi.coat(urushi.conductor(0.04, COLOR), 0.09, 1.6, sigma_t=-0.5 * np.log(COLOR))
    expected, _ = urushi.simulate(stack, wi, wo, walks=8192)
    reference = values(loaded(reference=True, **shared), wi, wo, 1024)
    # Noise of 2 %, and multiple scattering between the base's facets, which the walk leaves out.
    assert error(reference, expected, wi, wo) < 0.04
    assert error(values(loaded(**shared), wi, wo), expected, wi, wo) < 0.05


FLAKES = dict(base_color=(0.05, 0.05, 0.06), base_metalness=1.0, specular_roughness=0.3)
FLAKES |= dict(thin_film_weight=1.0, thin_film_thickness=0.31, thin_film_ior=2.3)
RUST = dict(base_color=(0.9, 0.5, 0.1), base_metalness=1.0, specular_roughness=0.95)
TURNED = BRUSHED | dict(coat_roughness_anisotropy=0.6, coat_roughness=0.5)
#: It reflects totally from another angle than the base, whose index is below the coat's.
FILM = dict(thin_film_weight=0.8, thin_film_ior=1.34, specular_ior=1.6, coat_ior=1.65)
FILM |= dict(specular_roughness=0.34, coat_roughness=0.23, thin_film_thickness=0.5)
FILM |= dict(base_color=(0.98, 0.9, 0.85), coat_color=(1.0, 1.0, 1.0))
LOW = dict(specular_ior=1.26, specular_roughness=0.65, base_diffuse_roughness=1.0, coat_ior=1.8)

PLASTIC = dict(specular_roughness_anisotropy=0.44, coat_roughness=0.0, base_color=(0.8,) * 3)
PLASTIC |= dict(coat_color=(1.0, 1.0, 1.0))
INDICES = dict(specular_roughness=0.3, base_metalness=0.7, coat_ior=1.8)
MIXTURE = dict(base_metalness=0.6, specular_roughness=0.3, coat_roughness=0.5)
MIXTURE |= dict(base_color=(0.98, 0.9, 0.85), coat_color=(1.0, 1.0, 1.0))

#: Coated bases, the bounds of E against the walk and of the error of each channel's light: 2 % of
#: tables, 4 % of two widths, 10 % of codes of textures and of a base of two widths that reflects
#: totally, and the walk's noise. Neither side of
#: TURNED has the light that facets of two widths scatter more than once. A film in the coat by one
#: mean colour had an E of 13 %.
COATED = {
    "mixture of indices": (0.03, 0.03, INDICES),
    "two widths": (0.08, 0.08, TURNED | dict(energy_compensation=False)),
    "brushed plastic": (0.1, 0.09, PLASTIC),
    "low index": (0.03, 0.03, LOW),
    "rough metal": (0.05, 0.03, RUST | dict(coat_roughness=0.7)),
    "film": (0.04, 0.04, FLAKES | dict(coat_roughness=0.1, coat_color=(1.0, 1.0, 1.0))),
    "textured mixture": (0.1, 0.1, MIXTURE | dict(varying="base_color")),
    "textured film": (0.1, 0.1, FILM | dict(varying="thin_film_thickness")),
}


@pytest.mark.parametrize("name", COATED)
def test_coats_agree_with_the_reference(name):
    most, brightness, parameters = COATED[name]
    shared = dict(base_color=COLOR, coat_weight=1.0, coat_color=(0.5, 0.9, 0.2), coat_roughness=0.4)
    shared |= parameters
    if varying := shared.pop("varying", None):  # a texture that hardly varies
        shared[varying] = nearly(shared[varying], 3 if varying.endswith("color") else 1)
    wi, wo = pairs(300)
    reference = values(loaded(reference=True, **shared), wi, wo, 2048)
    found = values(loaded(**shared), wi, wo)
    assert error(found, reference, wi, wo) < most
    weight = (wi[:, 2] * wo[:, 2])[:, None]
    light = (found * weight).sum(0) / (reference * weight).sum(0)
    assert np.abs(light - 1).max() < brightness


def test_a_grey_base_of_two_widths_under_a_smooth_coat_is_as_bright_as_walks():
    """Its albedo within 2.5 %, of which 0.5 % is the noise of walks."""
    material = {
        "base_color": (0.5, 0.5, 0.5),
        "specular_roughness": 0.5,
        "specular_roughness_anisotropy": 0.7,
        "coat_weight": 1.0,
        "energy_compensation": False,
    }
    wi = np.array([toward(cosine, 30.0) for cosine in (0.95, 0.7, 0.4)])
    found, expected = (
        sampled(loaded(**material, reference=walks), wi, 1 << 13)[0][..., 0].mean(1)
        for walks in (False, True)
    )
    np.testing.assert_allclose(found, expected, rtol=0.025)


def test_a_base_that_becomes_black_by_its_weight_is_linear_in_it_under_a_coat():
    """Between texels of weight and coat colour, f is that of their mean, within the 2 % of codes
    where a table is exact."""
    texels = np.float32([[0.0, 0.0], [1.0, 1.0]]), np.float32([[1.0, 0.03], [1.0, 0.03]])
    names = "base_weight", "coat_color"
    shared, (wi, wo) = dict(coat_weight=1.0), pairs(300)
    textures = (bitmap(x[..., None], wrap_mode="clamp") for x in texels)
    textured = loaded(**shared, **dict(zip(names, textures, strict=True)))
    for u, v in ((0.3, 0.3), (0.3, 0.6), (0.5, 0.35), (0.7, 0.7)):
        weight, x = np.clip(2 * np.array([v, u]) - 0.5, 0, 1).tolist()
        color = 1 - 0.97 * x
        constant = loaded(**shared, base_weight=weight, coat_color=(color,) * 3)
        found, expected = (evaluated(x, wi, wo, (u, v))[0] for x in (textured, constant))
        assert error(found, expected, wi, wo) < 0.02, (weight, color)


def test_a_smooth_coat_tells_the_coat_above_it_its_lobe():
    """Over black, f in the mirrored direction is the lobe, up to single precision."""
    black = {"base_weight": 0.0, "specular_weight": 0.0}
    bsdf, wi = loaded(**black, coat_weight=1.0, coat_ior=0.69), np.array([toward(0.9)])
    wo = wi * [-1.0, -1.0, 1.0]
    lobe = probing.known_lobes(bsdf, np.array([[0.5, 0.5]]))[0]
    np.testing.assert_allclose(values(bsdf, wi, wo)[0], lobes.f(lobe, wi, wo), rtol=1e-5)


def test_fuzz_adds_and_hides():
    """At a coverage and a colour of one, a black base under fuzz reflects the fuzz's albedo."""
    bsdf = loaded(
        base_color=(0.0, 0.0, 0.0), specular_weight=0.0, fuzz_weight=1.0, fuzz_roughness=0.4
    )
    for cosine in (0.9, 0.3):
        weight = sampled(bsdf, toward(cosine), 1 << 17, mode="Radiance")[0][0, :, 0]
        mean, se = weight.mean(), weight.std() / len(weight) ** 0.5
        assert abs(mean - formulas.fuzz_albedo(cosine, 0.4, NUMPY)) < 4 * se + 0.02 * mean


@pytest.mark.parametrize("thin", [False, True])
def test_light_that_is_traced_from_emitters_finds_the_same_fuzz(thin):
    """f of importance is f of radiance with its directions exchanged (Veach 1997, 3.7.6)."""
    fuzz = dict(fuzz_weight=0.8, fuzz_color=(0.9, 0.5, 0.2))
    bsdf, (wi, wo) = loaded(geometry_thin_walled=thin, **fuzz), pairs(256)
    seen, exchanged = values(bsdf, wi, wo), values(bsdf, wo, wi)
    assert np.abs(seen / exchanged - 1).max() > 0.05  # the fuzz is not reciprocal
    light = evaluated(bsdf, wi, wo, mode="Importance")[0]
    np.testing.assert_allclose(light, exchanged, rtol=1e-4)


def test_a_spectrum_is_its_colour_or_its_number():
    spectrum = {"type": "spectrum", "value": [(400, 0.1), (700, 0.9)]}
    color = mi.load_dict(spectrum).eval(mi.SurfaceInteraction3f()).numpy().ravel()
    even = {"type": "spectrum", "value": 0.5}
    for name, given, expected in (
        ("base_color", spectrum, tuple(color)),
        ("base_color", even, 0.5),
        ("specular_roughness", even, 0.5),
    ):
        found = [values(loaded(**{name: x}), *pairs(64)) for x in (given, expected)]
        np.testing.assert_allclose(*found, rtol=1e-5)


def test_values_of_textures_end_where_their_parameters_do():
    """They have derivatives at the ends."""
    given = {name: strip(-3.0, 4.0) for name in ("base_metalness", "coat_ior", "base_color")}
    given |= {"subsurface_scatter_anisotropy": strip(-3.0, 4.0)}
    inputs, si = Inputs.of(given, "openpbr"), dr.zeros(mi.SurfaceInteraction3f, 2)
    si.uv = mi.Point2f([0.25, 0.75], 0.5)
    at = inputs.at(si, mi.Bool(True))
    for name, low, high in zip(given, (0, 0, 0, -1), (1, 4, 1, 1), strict=True):
        value = np.atleast_2d(getattr(at, name).numpy())
        np.testing.assert_array_equal(value, np.broadcast_to([low, high], value.shape))
    ends = mi.Float(0.0, 1.0)
    dr.enable_grad(ends)
    dr.backward(clipped("base_metalness", ends))
    np.testing.assert_array_equal(dr.grad(ends).numpy(), 1)


def direction(x, y, z):
    """A map of one direction, as 0.5 n + 0.5."""
    return strip(0.5 * np.float32([x, y, z]) + 0.5)


def test_opacity_and_a_flat_normal_map():
    """What is transparent passes straight. Filters of bitmaps have a resolution of 8 bits."""
    wi, wo = pairs(50)
    plain, half, mapped = (
        values(loaded(base_color=COLOR, **x), wi, wo)
        for x in ({}, dict(geometry_opacity=0.5), dict(geometry_normal=direction(0, 0, 1)))
    )
    np.testing.assert_allclose(half, 0.5 * plain, rtol=1e-5)
    np.testing.assert_allclose(mapped, plain, 2e-2, 1e-3)


@pytest.mark.parametrize("coat_weight", [0.0, pytest.param(1.0, marks=pytest.mark.slow)])
def test_a_tangent_across_turns_the_surface(coat_weight):
    shared = dict(base_color=COLOR, coat_weight=coat_weight, coat_roughness=0.3, **BRUSHED)
    wi, wo = pairs(200)
    found = values(loaded(geometry_tangent=direction(0, 1, 0), **shared), wi, wo)
    # Seen from the tangent's frame: x is along the shape's y axis.
    inside = [np.stack([w[:, 1], -w[:, 0], w[:, 2]], -1) for w in (wi, wo)]
    expected = values(loaded(**shared), *inside)
    assert np.allclose(found, expected, rtol=1e-3, atol=1e-5)
    assert not np.allclose(found, values(loaded(**shared), wi, wo), rtol=0.2)


def test_tangents_that_vary_are_seen_below_a_coat():
    """Where the tangent is across, the coated base is that of the constant tangent."""
    wi, wo = pairs(200)

    def coated(*tangents):
        base = loaded(geometry_tangent=strip(*tangents, filter_type="nearest"), **BRUSHED)
        coat = {"type": "neural_layered", "alpha": 0.3, "resolution": 2, "base": base}
        return evaluated(mi.load_dict(coat), wi, wo, (0.25, 0.5))[0]

    along, across = (1.0, 0.5, 0.5), (0.5, 1.0, 0.5)
    assert error(coated(across, along), coated(across), wi, wo) < 0.02


def test_a_coat_has_the_frame_of_the_base():
    wi, wo = pairs(50)
    shared = dict(base_color=COLOR, coat_weight=1.0, coat_roughness=0.3) | WALKS

    def mapped(coat_normal=None, **options):
        normals = {"geometry_normal": direction(0.1, 0, 0.995)}
        if coat_normal:
            normals["geometry_coat_normal"] = direction(*coat_normal)
        return loaded(**shared, **normals, **options)

    plain = values(mapped(), wi, wo)
    assert np.array_equal(values(mapped((0.1, 0, 0.995)), wi, wo), plain)
    with pytest.raises(RuntimeError, match="geometry_coat_normal differs from geometry_normal"):
        mapped((0, 0, 1))
    assert np.array_equal(values(mapped((0, 0, 1), unsupported="ignore"), wi, wo), plain)
    across = dict(coat_roughness_anisotropy=0.5, geometry_coat_tangent=direction(0, 1, 0)) | shared
    loaded(**across)  # over an isotropic base
    with pytest.raises(RuntimeError, match="geometry_coat_tangent differs from geometry_tangent"):
        loaded(specular_roughness_anisotropy=0.5, **across)


def test_reference_may_be_named_by_the_plugin_of_the_coat():
    wi, wo = pairs(64)
    shared = dict(coat_weight=1.0, coat_color=COLOR, energy_compensation=False)
    walk, networks = (values(loaded(reference=flag, **shared), wi, wo) for flag in (True, False))
    assert np.array_equal(values(loaded(reference="layered", **shared), wi, wo), walk)
    assert np.array_equal(values(loaded(reference="neural_layered", **shared), wi, wo), networks)
    assert not np.array_equal(walk, networks)


@pytest.mark.slow
def test_a_path_computes_a_vertex_once(monkeypatch):
    """Light and continuation share the codes and the parameters of the vertex."""
    bsdf, calls = loaded(coat_weight=1.0), {}
    for name in ("_vertex", "_f_and_pdf"):
        calls[name] = Mock(side_effect=getattr(bsdf.surface, name))
        monkeypatch.setattr(bsdf.surface, name, calls[name])
    picture = mi.render(mi.load_dict(spheres(bsdf, size=4)), spp=1)
    assert np.isfinite(np.array(picture)).all()
    # Towards the light and along the drawn direction, as often as the loop is recorded.
    assert calls["_vertex"].call_count
    assert calls["_f_and_pdf"].call_count == 2 * calls["_vertex"].call_count
