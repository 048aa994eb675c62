"""Small random networks, a saved material, and BSDFs to nest, for the plugins' tests."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from urushi.nets import weights
from urushi.nets.architecture import Architecture, init
from urushi.nets.weights import Model

ARCH = Architecture(decoder=(16, 16), encoder=(24,), layerer=(24,), sampler=(12,), probes=48)


@pytest.fixture(scope="session")
def networks(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A file of small networks whose materials differ much: kernels compile in no time.

    The proposal's output is scaled up, so that its mixtures reach from widths of 0.01 to 1 and
    from one lobe to all.
    """
    params = init(ARCH, seed=3)
    rng = np.random.default_rng(5)
    params["sampler.1.weight"] = 40 * params["sampler.1.weight"]
    params["decoder.2.weight"] = 3 * params["decoder.2.weight"]
    params["layerer.1.weight"] = 5 * params["layerer.1.weight"]
    params["layerer.1.bias"] = rng.normal(size=32).astype(np.float32)
    path = tmp_path_factory.mktemp("weights") / "small.safetensors"
    weights.save(path, ARCH, params, {})
    return path


@pytest.fixture(scope="session")
def model(networks: Path) -> Model:
    """The same networks, loaded."""
    return weights.load(networks)


@pytest.fixture
def rgb():
    """Mitsuba in the variant llvm_ad_rgb."""
    return use("llvm_ad_rgb")


def use(variant: str):
    """Mitsuba in a variant."""
    import mitsuba as mi

    import urushi  # noqa: F401  (registers the plugins)

    mi.set_variant(variant)
    return mi


@pytest.fixture(scope="session")
def sampling():
    """The module of the chi-squared test beside this file."""
    path = Path(__file__).with_name("sampling.py")
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
