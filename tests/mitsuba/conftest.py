"""Small random networks, a saved material, and BSDFs to nest, for the plugins' tests."""

from pathlib import Path

import pytest
from tests.measured import writers
from tests.untrained import untrained

from urushi.measured import merl
from urushi.measured.tabulated import tabulated
from urushi.nets import weights
from urushi.nets.weights import Model


@pytest.fixture(scope="session")
def networks(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A file of untrained networks with very different materials; codes have 32 numbers.

    The proposal's terms are scaled up, so that its mixtures have from one lobe to all lobes.
    """
    model = untrained(3, functions=26, layerer=(24,))
    params = dict(model.params)
    params["proposal.weight"] = 3 * params["proposal.weight"]
    path = tmp_path_factory.mktemp("weights") / "small.safetensors"
    weights.save(path, model.arch, params, {})
    return path


@pytest.fixture(scope="session")
def model(networks: Path) -> Model:
    """The same networks, loaded."""
    return weights.read(networks)


@pytest.fixture(scope="session")
def merl_file(tmp_path_factory):
    """A MERL file of a plastic that is dark enough to gain no energy."""
    rows = tabulated(lambda wi, wo: 0.5 * writers.plastic(wi, wo), merl.SHAPE).reshape(-1, 3)
    return writers.write_merl(tmp_path_factory.mktemp("merl") / "plastic.binary", rows)
