"""Networks in PyTorch's files: they keep their values, and hostile files do nothing."""

import io
import zipfile
from pathlib import Path

import numpy as np
import pytest
from fan2022 import Material, PaperNetworks, architecture, published
from fan2022.__main__ import main
from fan2022.architecture import EVALUATION, LAYERING, Linear, PaperArchitecture
from fan2022.inference import direction_inputs, evaluate, layer
from fan2022.torch_files import state_dict
from tests.fan2022 import torch_writer
from tests.fan2022.torch_writer import EMPTY, dictionary, integer, named, tensor, text, write

from urushi.errors import FileError


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
    return [
        write(folder / f"{name}.pth", *torch_writer.state_dict(in_torch(params, chain)))
        for name, chain in (("representation", EVALUATION), ("layering", LAYERING))
    ]


def test_networks_keep_their_values(params, files, pairs):
    """The layering is `layering.py`: layerer(input - 1) + 1, albedo and sigma_t plus 1 before."""
    read = published.networks(*files)
    rng = np.random.default_rng(2)
    z = (1 + 0.5 * rng.normal(size=(300, 32))).astype(np.float32)
    directions = direction_inputs(*(w[:300] for w in pairs))
    np.testing.assert_array_equal(evaluate(read, z, directions), evaluate(params, z, directions))
    albedo, sigma_t = rng.random((2, 300)).astype(np.float32)
    x = np.concatenate([z, z[::-1], albedo[:, None] + 1, sigma_t[:, None] + 1], axis=1)
    expected = architecture.apply(params, LAYERING, x - 1) + 1
    found = layer(read, z, z[::-1], albedo, sigma_t)
    np.testing.assert_allclose(found, expected, atol=1e-5 * np.abs(expected).max())


def test_checkpoints_parameters_doubles_and_halves_are_read(params, files, tmp_path):
    """As a checkpoint with other entries, of parameters, in other precisions."""
    expected = published.networks(*files)
    for kind, tolerance in (("<f8", 0), ("<f2", 2e-3)):
        tensors = {n: a.astype(kind) for n, a in in_torch(params, EVALUATION).items()}
        program, storages = torch_writer.state_dict(tensors, parameter=True)
        checkpoint = b"}(" + text("epoch") + integer(49) + text("loss") + b"G" + bytes(8)
        checkpoint += text("optimizer") + b"}" + integer(0) + b"]s" + text("model") + program + b"u"
        path = write(tmp_path / "checkpoint.pth", checkpoint, storages)
        read = published.networks(path, files[1])
        for name, value in read.items():
            np.testing.assert_allclose(value, expected[name], rtol=tolerance, atol=tolerance)


def test_files_that_pytorch_1_2_wrote_in_the_authors_form_are_read(tmp_path):
    """The bound method `state_dict`; `published/save.py` wrote the files and the outputs.

    All parameters are views of one storage. The format is the older one; damage is seen there, too.
    """
    folder = Path(__file__).parent / "published"
    read = published.networks(folder / "RepreNetwork.pth", folder / "LayeringNetwork.pth")
    with np.load(folder / "values.npz") as values:
        for name, chain in (("Repre", EVALUATION), ("Layering", LAYERING)):
            found = architecture.apply(read, chain, values[f"{name} inputs"])
            np.testing.assert_allclose(found, values[f"{name} outputs"], atol=1e-5)
    path, data = tmp_path / "old.pth", (folder / "RepreNetwork.pth").read_bytes()
    for content in (
        data[:-1],
        data[: len(data) // 2],
        data[:20],
        data.replace(b"\xe9\x03", b"\xea\x03", 1),  # the format's version
    ):
        path.write_bytes(content)
        with pytest.raises(FileError, match="is damaged"):
            state_dict(path)


def test_a_whole_network_is_read(tmp_path):
    """Of one module in another."""
    values = np.arange(6, dtype=np.float32).reshape(2, 3)
    parameters = EMPTY + b"(" + text("weight") + tensor(values, "0", parameter=True) + b"u"
    inner = NETWORK + modules(parameters=parameters) + b"b"
    path = write(tmp_path / "a.pth", NETWORK + modules(inner) + b"b", {"0": values.tobytes()})
    np.testing.assert_array_equal(state_dict(path)["0.weight"], values)


def test_one_command_makes_weights_for_all_others(params, files, tmp_path, capsys):
    output = tmp_path / "published.safetensors"
    paths = [str(path) for path in files]
    assert main(["import", *paths, "-o", str(output)]) == 0
    model = PaperNetworks.read(output)
    assert capsys.readouterr().out == f"{output}  {model.fingerprint}\n"
    assert model.header["published"]["layering"]["file"] == "layering.pth"
    material = Material(np.ones((1, 32)), model)
    assert (material.f([[0, 0, 1]], [[0.6, 0, 0.8]]) >= 0).all()
    # The sampler without training: nearly the cosine's density everywhere.
    wi, wo = np.array([[0.6, 0, 0.8]]), np.array([[0.0, 0.9, np.sqrt(0.19)]])
    np.testing.assert_allclose(material.pdf(wi, wo), wo[:, 2] / np.pi, rtol=0.03)
    assert model.arch == PaperArchitecture(pairs=64)
    assert main(["import", *paths, "-o", str(output), "--projection-pairs", "4096"]) == 0
    assert PaperNetworks.read(output).arch == PaperArchitecture()


def test_a_file_of_another_network_is_refused(params, files, tmp_path):
    _, layering = files
    with pytest.raises(FileError, match="the paper's has 26; give the representation network"):
        published.networks(layering, layering)
    tensors = in_torch(params, EVALUATION)
    names = [name for name in tensors if name.endswith("weight") and "linear" in name]

    def refused(tensors, match):
        path = write(tmp_path / "other.pth", *torch_writer.state_dict(tensors))
        with pytest.raises(FileError, match=match):
            published.networks(path, layering)

    two = [name.removesuffix("weight") for name in names[1:3]]
    swapped = tensors | {
        one + part: tensors[other + part]
        for one, other in (two, two[::-1])
        for part in ("weight", "bias")
    }
    refused(swapped, r"Linear 2 of .* has a weight of shape \(256, 128\), the paper's has \(128, 2")
    refused({**tensors, "latents": np.ones((9, 32), np.float32)}, "layer '' of the representation")
    refused({**tensors, "a.running_mean": np.ones(3, np.float32)}, "neither a Linear nor a LayerN")
    wrong = {**tensors, names[0]: np.full((256, 38), np.nan, np.float32)}
    refused(wrong, "'module.linear0.weight' of '.*' holds a number that is not finite")
    huge = {**tensors, names[0]: np.full((256, 38), 1e300)}
    refused(huge, "not finite in single precision")


#: A network without attributes.
NETWORK = named("model", "Network") + b")\x81"


def method(value: bytes, name="state_dict") -> bytes:
    """The method of an object."""
    return named("__builtin__", "getattr") + value + text(name) + b"\x86R"


def modules(*inner: bytes, parameters: bytes = EMPTY) -> bytes:
    """Attributes of a network of modules."""
    parts = b"".join(text(str(i)) + part for i, part in enumerate(inner))
    names = b"}(" + text("_parameters") + parameters + text("_buffers") + EMPTY
    return names + text("_modules") + EMPTY + b"(" + parts + b"uu"


def hostile(target="") -> dict[str, tuple[bytes, str]]:
    """Pickles that must do nothing, with what the refusal says; some would make a file."""
    call = text(f"touch {target}") + b"\x85R"
    rebuild = named("torch._utils", "_rebuild_tensor_v2")
    return {
        "system": (named("os", "system") + call, r"'os\.system'.*nothing was run"),
        "stack global": (text("os") + text("system") + b"\x93" + call, r"'os\.system'"),
        "instance": (b"(" + text(f"touch {target}") + b"ios\nsystem\n", r"'os\.system'"),
        "dotted": (named("torch", "serialization.load") + b")R", r"'torch\.serialization\.load'"),
        "name in a class": (named("model", "torch.hub.load") + b")\x81", "'model.torch.hub.load'"),
        "new function": (rebuild + b")\x81", "damaged"),
        "class with arguments": (named("utils", "Config") + integer(1) + b"\x85\x81", "damaged"),
        "other method": (method(b"}", "__class__"), "damaged"),
        "method of a dictionary": (method(b"}"), "damaged"),
        "method of a method": (method(named("__builtin__", "getattr")), "damaged"),
        "attributes of a class": (named("torch", "Size") + b"}b", "holds none"),
        "slots of a function": (rebuild + b"N}" + text("__defaults__") + b")s\x86b", "holds none"),
        "no parameters": (method(NETWORK + b"}b"), "damaged"),
        "module in itself": (method(NETWORK + b"q\x00" + modules(b"h\x00") + b"b"), "damaged"),
        "module twice": (
            method(NETWORK + modules(NETWORK + modules() + b"bq\x00", b"h\x00") + b"b"),
            "damaged",
        ),
        "call of a storage": (named("torch", "FloatStorage") + b")R", "damaged"),
        "cyclic": (b"}q\x00" + text("a") + b"h\x00s", "holds none"),
        "empty stack": (b"R", "damaged"),
        "text that ends early": (b"X\xff\xff\xff\x7fabc", "damaged"),
    }


@pytest.mark.parametrize("name", hostile())
def test_a_hostile_pickle_is_refused_and_nothing_runs(name, tmp_path):
    target = tmp_path / "made"
    program, match = hostile(target)[name]
    path = write(tmp_path / "hostile.pth", program, {})
    with pytest.raises(FileError, match=match) as caught:
        state_dict(path)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)
    assert not target.exists()


@pytest.mark.parametrize(
    ("options", "storages"),
    [
        ({"shape": (2, 3), "offset": 1}, {"0": bytes(24)}),
        ({"shape": (2, 3), "strides": (4, 1)}, {"0": bytes(24)}),
        ({"shape": (2, 3), "strides": (-3, 1), "offset": 3}, {"0": bytes(24)}),
        ({"shape": (-2, 3)}, {"0": bytes(24)}),
        ({"shape": (1 << 16, 1 << 16), "strides": (0, 0)}, {"0": bytes(24)}),
        ({"shape": (2, 3)}, {"0": bytes(20)}),
        ({"shape": (2, 3)}, {}),
    ],
)
def test_shapes_outside_the_storage_are_refused(options, storages, tmp_path):
    program = dictionary({"a": tensor(np.ones(6, np.float32), "0", **options)})
    path = write(tmp_path / "a.pth", program, storages)
    with pytest.raises(FileError, match="lies outside its storage"):
        state_dict(path)


def test_files_of_other_kinds_are_refused(files, tmp_path):
    path, data = tmp_path / "other.pth", files[0].read_bytes()
    damaged = bytearray(data)
    damaged[len(data) // 2] ^= 1  # within a storage
    memory, words = io.BytesIO(), io.BytesIO()
    with zipfile.ZipFile(memory, "w", zipfile.ZIP_DEFLATED) as archive:  # small, of much memory
        archive.writestr("other/data.pkl", dictionary({"a": tensor(np.ones(6, np.float32), "0")}))
        archive.writestr("other/data/0", bytes(1 << 20))
    with zipfile.ZipFile(words, "w") as archive:
        archive.writestr("words.txt", "no tensors")
    for content in (data[: len(data) // 2], damaged, memory.getvalue(), words.getvalue()):
        path.write_bytes(content)
        with pytest.raises(FileError, match="is damaged"):
            state_dict(path)
    path.write_bytes(b"")
    with pytest.raises(FileError, match="is not a PyTorch file"):
        state_dict(path)
    with pytest.raises(FileError, match="cannot read .* No such file"):
        state_dict(tmp_path / "missing.pth")


#: Codes in R of the upper and the lower layer in the authors' `layering.py`, and of the output in
#: their README.
CODES = """
    1.0612 1.0654 1.0614 1.0730 0.9225 1.0260 0.9427 1.0506 0.9631 1.0320 1.0695 1.0979
    1.0565 0.9360 0.9368 0.9340 0.9689 0.9265 0.9611 0.9153 0.9335 1.0632 0.9161 1.0621
    1.0503 0.9159 1.0876 1.0519 0.9537 0.8968 1.0690 1.0926

    1.0357 1.0408 1.0111 1.0082 0.9337 1.0371 0.9698 1.0472 1.0252 0.9581 0.9941 0.9998
    1.0237 0.9839 0.9645 0.9899 1.0191 0.9807 0.9569 1.0062 0.9887 1.0228 0.9749 0.9871
    0.9560 1.0002 0.9644 0.9690 0.9858 0.8786 1.0145 1.0371

    1.0504 1.0140 0.9858 0.9929 0.9551 1.0667 1.0301 0.9681 0.9994 0.9346 0.9755 1.0965
    0.9729 0.9676 1.0273 0.9618 1.0504 0.9365 1.0141 0.9615 1.0063 0.9993 0.9564 1.0172
    0.9706 0.9159 1.0595 1.0985 1.0210 0.9151 0.9846 1.1005
"""


def test_the_authors_networks_layer_as_their_readme_prints(stored):
    """Four decimals are printed. The medium has albedo 1 and sigma_t 0."""
    paths = [stored(f"data/fan2022/{name}Network.pth") for name in ("Repre", "Layering")]
    top, bottom, expected = np.array(CODES.split(), np.float32).reshape(3, 1, 32)
    found = layer(published.networks(*paths), top, bottom, *np.float32([[1], [0]]))
    np.testing.assert_allclose(found, expected, atol=1e-4)
