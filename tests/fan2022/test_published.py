"""Networks in files of their tensors: they keep their values, and other files are refused."""

import pickle
import re
import zipfile
from pathlib import Path

import numpy as np
import pytest

from urushi.app import cli
from urushi.errors import FileError
from urushi.fan2022 import Material, PaperNetworks, architecture, published
from urushi.fan2022.architecture import EVALUATION, LAYERING, AdamProjection, Linear, init
from urushi.fan2022.inference import direction_inputs, evaluate, layer


@pytest.fixture(scope="module")
def params():
    """Random networks whose normalisations are not the identity."""
    rng = np.random.default_rng(1)
    return {
        name: value + 0.1 * rng.normal(size=value.shape).astype(np.float32)
        for name, value in init(0).items()
    }


def in_torch(params, chain) -> dict[str, np.ndarray]:
    """A network by names and in shapes of PyTorch."""
    tensors = {}
    for index, block in enumerate(published.flat(chain)):
        weight, bias = (params[name] for name in block.shapes())
        kind = "linear" if isinstance(block, Linear) else "norm"
        tensors[f"module.{kind}{index}.weight"] = np.ascontiguousarray(weight.T)
        tensors[f"module.{kind}{index}.bias"] = bias
    return tensors


@pytest.fixture(scope="module")
def files(params, tmp_path_factory):
    folder = tmp_path_factory.mktemp("torch")
    paths = []
    for name, chain in (("representation", EVALUATION), ("layering", LAYERING)):
        paths.append(folder / f"{name}.npz")
        np.savez(paths[-1], **in_torch(params, chain))
    return paths


def theirs(params, top, bottom, albedo, sigma_t):
    """`layering.py` of the authors: layerer(input - 1) + 1, albedo and sigma_t plus 1 before."""
    x = np.concatenate([top, bottom, albedo[:, None] + 1, sigma_t[:, None] + 1], axis=1)
    return architecture.apply(params, LAYERING, x - 1) + 1


def test_networks_keep_their_values(params, files, pairs):
    read = published.networks(*files)
    rng = np.random.default_rng(2)
    z = (1 + 0.5 * rng.normal(size=(300, 32))).astype(np.float32)
    directions = direction_inputs(*(w[:300] for w in pairs))
    np.testing.assert_array_equal(evaluate(read, z, directions), evaluate(params, z, directions))
    albedo, sigma_t = rng.random((2, 300)).astype(np.float32)
    expected = theirs(params, z, z[::-1], albedo, sigma_t)
    np.testing.assert_allclose(
        layer(read, z, z[::-1], albedo, sigma_t), expected, atol=1e-5 * np.abs(expected).max()
    )


def test_doubles_and_halves_are_read(params, files, tmp_path):
    expected = published.networks(*files)
    for kind, tolerance in (("<f8", 0), ("<f2", 2e-3)):
        tensors = {n: a.astype(kind) for n, a in in_torch(params, EVALUATION).items()}
        np.savez_compressed(tmp_path / "other.npz", **tensors)
        read = published.networks(tmp_path / "other.npz", files[1])
        for name, value in read.items():
            np.testing.assert_allclose(value, expected[name], rtol=tolerance, atol=tolerance)


def test_one_command_makes_weights_for_all_others(params, files, tmp_path, capsys):
    output = tmp_path / "published.safetensors"
    paths = [str(path) for path in files]
    assert cli.main(["paper", *paths, "-o", str(output)]) == 0
    model = PaperNetworks.read(output)
    assert capsys.readouterr().out == f"{output}  {model.fingerprint}\n"
    assert model.header["published"]["layering"]["file"] == "layering.npz"
    material = Material(np.ones((1, 32)), model)
    assert (material.f([[0, 0, 1]], [[0.6, 0, 0.8]]) >= 0).all()
    # The sampler without training: nearly the cosine's density everywhere.
    wi, wo = np.array([[0.6, 0, 0.8]]), np.array([[0.0, 0.9, np.sqrt(0.19)]])
    np.testing.assert_allclose(material.pdf(wi, wo), wo[:, 2] / np.pi, rtol=0.03)

    def projection(*arguments):
        assert cli.main(["paper", *paths, "-o", str(output), *arguments]) == 0
        return PaperNetworks.read(output).arch.adam

    assert model.arch.adam == AdamProjection(pairs=64)
    assert projection("--projection-pairs", "4096") == AdamProjection()


def test_a_file_of_another_network_is_refused(params, files, tmp_path):
    _, layering = files
    with pytest.raises(FileError, match="the paper's has 26; give the representation network"):
        published.networks(layering, layering)
    tensors = in_torch(params, EVALUATION)
    names = [name for name in tensors if name.endswith("weight") and "linear" in name]

    def refused(tensors, match):
        np.savez(tmp_path / "other.npz", **tensors)
        with pytest.raises(FileError, match=match):
            published.networks(tmp_path / "other.npz", layering)

    swapped = {**tensors, names[1]: tensors[names[2]], names[2]: tensors[names[1]]}
    swapped[names[1].replace("weight", "bias")] = tensors[names[2].replace("weight", "bias")]
    swapped[names[2].replace("weight", "bias")] = tensors[names[1].replace("weight", "bias")]
    refused(swapped, r"Linear 2 of .* has a weight of shape \(256, 128\), the paper's has \(128, 2")
    refused({**tensors, "latents": np.ones((9, 32), np.float32)}, "layer '' of the representation")
    refused({**tensors, "a.running_mean": np.ones(3, np.float32)}, "neither a Linear nor a LayerN")
    wrong = {**tensors, names[0]: np.full((256, 38), np.nan, np.float32)}
    refused(wrong, "Linear 1 of .*'module.linear0', holds a number that is not finite")
    huge = {**tensors, names[0]: np.full((256, 38), 1e300)}
    refused(huge, "not finite in single precision")
    refused(
        {**tensors, "epoch.weight": np.ones(3, int)}, "array 'epoch.weight', which is not of floats"
    )


def test_files_of_other_kinds_are_refused_in_one_sentence(files, tmp_path):
    whole = files[0].read_bytes()
    path = tmp_path / "file.npz"
    with pytest.raises(FileError, match="it does not exist; write it with numpy.savez"):
        published.networks(path, files[1])
    pickled = tmp_path / "pickled.npz"
    np.savez(pickled, a=np.array([print], object))
    with zipfile.ZipFile(tmp_path / "torch.npz", "w") as archive:  # as of torch.save
        archive.writestr("network/data.pkl", pickle.dumps({"a": 1.0}))
    contents = {
        "text": b"no network",
        "pickle": pickle.dumps({"a": 1.0}),
        "truncated": whole[: len(whole) // 2],
        "changed": whole[:2000] + bytes(100) + whole[2100:],
        "object array": pickled.read_bytes(),
        "torch": (tmp_path / "torch.npz").read_bytes(),
    }
    for content in contents.values():
        path.write_bytes(content)
        with pytest.raises(
            FileError, match="it is not an NPZ file; write it with numpy.savez"
        ) as caught:
            published.networks(path, files[1])
        assert "\n" not in str(caught.value)


def test_the_script_of_the_documentation_writes_the_files(params, tmp_path, monkeypatch):
    """The authors' files hold a network's method `state_dict`, which a stand-in returns here."""
    torch = pytest.importorskip("torch")
    text = (Path(__file__).parents[2] / "docs" / "published.md").read_text(encoding="utf-8")
    script = re.search(r"```py\n(.*?)```", text, re.DOTALL)[1]
    states = {
        f"{name}Network.pth": {
            key: torch.from_numpy(array.copy()) for key, array in in_torch(params, chain).items()
        }
        for name, chain in (("Repre", EVALUATION), ("Layering", LAYERING))
    }
    monkeypatch.setattr(torch, "load", lambda path, **options: lambda: states[path])
    monkeypatch.chdir(tmp_path)
    exec(script)
    read = published.networks("RepreNetwork.npz", "LayeringNetwork.npz")
    for name, value in read.items():
        np.testing.assert_array_equal(value, params[name])


def codes(text):
    """Numbers that the authors print."""
    return np.array(text.split(), np.float32)


#: Codes of the authors' `layering.py`: of the upper layer, the same for R, G and B, ...
TOP = codes("""
    1.0612 1.0654 1.0614 1.0730 0.9225 1.0260 0.9427 1.0506 0.9631 1.0320 1.0695 1.0979
    1.0565 0.9360 0.9368 0.9340 0.9689 0.9265 0.9611 0.9153 0.9335 1.0632 0.9161 1.0621
    1.0503 0.9159 1.0876 1.0519 0.9537 0.8968 1.0690 1.0926
""")
#: ... and of the lower layer.
BOTTOM = codes("""
    1.0357 1.0408 1.0111 1.0082 0.9337 1.0371 0.9698 1.0472 1.0252 0.9581 0.9941 0.9998
    1.0237 0.9839 0.9645 0.9899 1.0191 0.9807 0.9569 1.0062 0.9887 1.0228 0.9749 0.9871
    0.9560 1.0002 0.9644 0.9690 0.9858 0.8786 1.0145 1.0371 1.0406 1.0501 1.0168 1.0147
    0.9320 1.0019 0.9645 1.0687 1.0633 1.0077 1.0002 1.0204 1.0279 0.9733 0.9622 0.9880
    0.9869 0.9796 0.9412 1.0024 0.9851 1.0293 0.9760 1.0081 0.9759 0.9985 0.9706 0.9612
    0.9785 0.9028 1.0155 1.0274 1.0375 1.0488 1.0276 1.0250 0.9497 0.9905 0.9466 1.0764
    1.1145 1.0373 1.0133 1.0048 1.0359 0.9605 0.9625 0.9859 0.9715 0.9764 0.9293 0.9847
    0.9677 1.0352 0.9703 1.0174 0.9892 0.9832 1.0055 0.9529 0.9692 0.9253 1.0243 1.0123
""")
#: Its output in their README, which leaves out the lines of the numbers 48 to 59 and 72 to 83.
LAYERED = codes("""
    1.0504 1.0140 0.9858 0.9929 0.9551 1.0667 1.0301 0.9681 0.9994 0.9346 0.9755 1.0965
    0.9729 0.9676 1.0273 0.9618 1.0504 0.9365 1.0141 0.9615 1.0063 0.9993 0.9564 1.0172
    0.9706 0.9159 1.0595 1.0985 1.0210 0.9151 0.9846 1.1005 1.0531 1.0070 0.9834 0.9946
    0.9427 1.0695 1.0329 0.9671 1.0030 0.9307 0.9717 1.0957 0.9655 0.9536 1.0258 0.9603
    1.0166 0.9141 0.9857 1.0903 1.0593 1.0096 0.9855 0.9977 0.9450 1.0692 1.0376 0.9607
    0.9988 0.9997 0.9404 1.0150 0.9876 0.9113 1.0639 1.0914 1.0155 0.9163 0.9827 1.0837
""")


def test_the_authors_networks_layer_as_their_readme_prints(test_data):
    """Four decimals are printed. The medium has albedo 1 and sigma_t 0."""
    folder = test_data / "data" / "fan2022"
    paths = [folder / f"{name}Network.npz" for name in ("Repre", "Layering")]
    if not all(path.is_file() for path in paths):
        pytest.skip(f"no networks of Fan et al. 2022 in '{folder}'")
    read = published.networks(*paths)
    found = layer(read, TOP, BOTTOM.reshape(3, 32), np.ones(3, np.float32), np.zeros(3, np.float32))
    printed = np.r_[0:48, 60:72, 84:96]
    np.testing.assert_allclose(found.ravel()[printed], LAYERED, atol=1e-4)
