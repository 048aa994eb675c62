"""Networks in PyTorch's files: they keep their values, and hostile files do nothing."""

import io
import os
import pickle
import subprocess
import sys
import zipfile
from collections import OrderedDict
from types import ModuleType

import numpy as np
import pytest
from tests.paper import torch_writer as writer
from tests.paper.torch_writer import dictionary, integer, named, state_dict, tensor, text, write

from urushi.app import cli
from urushi.errors import FileError
from urushi.material import Material
from urushi.nets import weights
from urushi.paper import published
from urushi.paper.architecture import EVALUATION, LAYERING, AdamProjection, init
from urushi.paper.blocks import Linear
from urushi.paper.inference import direction_inputs, evaluate, layer
from urushi.paper.torch_file import MAX_PICKLE, TorchFile


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
    return [
        write(folder / f"{name}.pth", *state_dict(in_torch(params, chain)))
        for name, chain in (("representation", EVALUATION), ("layering", LAYERING))
    ]


def theirs(params, top, bottom, albedo, sigma_t):
    """The layering network as published: codes in and out as they are."""
    from urushi.paper import blocks

    x = np.concatenate([top, bottom, albedo[:, None], sigma_t[:, None]], axis=1)
    return blocks.apply(params, LAYERING, x)


def test_networks_keep_their_values(params, files, pairs):
    """To float precision; the layering network's codes are shifted into its biases."""
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


def test_checkpoints_parameters_doubles_and_halves_are_read(params, files, tmp_path):
    """As a checkpoint with other entries, of parameters, in other precisions."""
    expected = published.networks(*files)
    for kind, tolerance in (("<f8", 0), ("<f2", 2e-3)):
        tensors = {n: a.astype(kind) for n, a in in_torch(params, EVALUATION).items()}
        program, storages = state_dict(tensors, parameter=True)
        checkpoint = b"}(" + text("epoch") + integer(49) + text("loss") + b"G" + bytes(8)
        checkpoint += text("optimizer") + b"}" + integer(0) + b"]s" + text("model") + program + b"u"
        path = write(tmp_path / "checkpoint.pth", checkpoint, storages)
        read = published.networks(path, files[1])
        for name, value in read.items():
            np.testing.assert_allclose(value, expected[name], rtol=tolerance, atol=tolerance)


def test_tensors_that_share_a_storage_are_cut_out_of_it(tmp_path):
    values = np.arange(24, dtype=np.float32)
    program = dictionary(
        {
            "first": tensor(values, "0", shape=(2, 3)),
            "turned": tensor(values, "0", shape=(3, 2), strides=(1, 3), offset=12),
        }
    )
    with TorchFile(write(tmp_path / "a.pth", program, {"0": values.tobytes()})) as file:
        arrays = {name: file.array(t, name) for name, t in published.state_dict(file).items()}
    np.testing.assert_array_equal(arrays["first"], values[:6].reshape(2, 3))
    np.testing.assert_array_equal(arrays["turned"], values[12:18].reshape(2, 3).T)


@pytest.mark.parametrize("protocol", [2, 4])
def test_what_pythons_own_pickler_writes_for_a_state_dict_is_read(protocol, tmp_path, monkeypatch):
    """With its memo and its state `_metadata`; stand-ins have the names of PyTorch's functions."""
    torch, utils = ModuleType("torch"), ModuleType("torch._utils")
    torch.FloatStorage = type("FloatStorage", (), {"__module__": "torch"})

    def _rebuild_tensor_v2():
        """Named in the pickle, never called."""

    _rebuild_tensor_v2.__module__ = "torch._utils"
    _rebuild_tensor_v2.__qualname__ = "_rebuild_tensor_v2"
    utils._rebuild_tensor_v2 = _rebuild_tensor_v2
    torch._utils = utils
    monkeypatch.setitem(sys.modules, "torch", torch)
    monkeypatch.setitem(sys.modules, "torch._utils", utils)
    arrays = {"a.weight": np.ones((300, 2), np.float32), "a.bias": np.zeros(300, np.float32)}

    class Storage:
        def __init__(self, array):
            self.array = array

    class Standin:
        def __init__(self, array):
            self.storage = Storage(array)

        def __reduce__(self):
            shape = self.storage.array.shape
            strides = tuple(int(np.prod(shape[i + 1 :])) for i in range(len(shape)))
            return _rebuild_tensor_v2, (self.storage, 0, shape, strides, False, OrderedDict())

    class Pickler(pickle.Pickler):
        def persistent_id(self, value):
            if not isinstance(value, Storage):
                return None
            key = str([a is value.array for a in arrays.values()].index(True))
            return "storage", torch.FloatStorage, key, "cuda:0", value.array.size

    content = OrderedDict((name, Standin(array)) for name, array in arrays.items())
    content._metadata = OrderedDict([("", {"version": 1}), ("a", {"version": 1})])
    Pickler(buffer := io.BytesIO(), protocol).dump(content)
    program = buffer.getvalue()[2:-1]  # `write` adds the first and the last instruction
    storages = {str(i): array.tobytes() for i, array in enumerate(arrays.values())}
    with TorchFile(write(tmp_path / "a.pth", program, storages)) as file:
        for name, value in published.state_dict(file).items():
            np.testing.assert_array_equal(file.array(value, name), arrays[name])


def test_files_of_pytorch_itself(params, tmp_path):
    torch = pytest.importorskip("torch")
    paths = []
    for name, chain in (("representation", EVALUATION), ("layering", LAYERING)):
        tensors = {n: torch.from_numpy(a.copy()) for n, a in in_torch(params, chain).items()}
        paths.append(tmp_path / f"{name}.pth")
        torch.save(tensors, paths[-1])
    read = published.networks(*paths)
    np.testing.assert_array_equal(read["evaluation.0.weight"], params["evaluation.0.weight"])
    torch.save(tensors, paths[-1], _use_new_zipfile_serialization=False)
    with pytest.raises(FileError, match=r"before version 1\.6"):
        published.networks(*paths)


def test_one_command_makes_weights_for_all_others(params, files, tmp_path, capsys):
    output = tmp_path / "published.safetensors"
    paths = [str(path) for path in files]
    assert cli.main(["paper", "import", *paths, "-o", str(output)]) == 0
    model = weights.read(output)
    assert capsys.readouterr().out == f"{output}  {model.fingerprint}\n"
    assert model.header["published"]["layering"]["file"] == "layering.pth"
    material = Material(np.ones((1, 32)), model)
    assert (material.f([[0, 0, 1]], [[0.6, 0, 0.8]]) >= 0).all()
    # The sampler without training: nearly the cosine's density everywhere.
    wi, wo = np.array([[0.6, 0, 0.8]]), np.array([[0.0, 0.9, np.sqrt(0.19)]])
    np.testing.assert_allclose(material.pdf(wi, wo), wo[:, 2] / np.pi, rtol=0.03)

    def projection(*arguments):
        assert cli.main(["paper", "import", *paths, "-o", str(output), *arguments]) == 0
        return weights.read(output).arch.adam

    assert model.arch.adam == AdamProjection(pairs=64)
    assert projection("--projection-pairs", "4096") == AdamProjection()
    other = ["--projection", "levenberg-marquardt"]
    assert projection(*other) is None
    wrong = [*other, "--projection-pairs", "64"]
    assert cli.main(["paper", "import", *paths, "-o", str(output), *wrong]) == 2
    assert "--projection-pairs needs --projection adam" in capsys.readouterr().err

    assert cli.main(["paper", "tensors", paths[0]]) == 0
    assert "module.linear0.weight  256 × 38\n" in capsys.readouterr().out


def test_a_file_of_another_network_is_refused(params, files, tmp_path):
    _, layering = files
    with pytest.raises(FileError, match="the paper's has 26; give the representation network"):
        published.networks(layering, layering)
    tensors = in_torch(params, EVALUATION)
    names = [name for name in tensors if name.endswith("weight") and "linear" in name]

    def refused(tensors, match):
        path = write(tmp_path / "other.pth", *state_dict(tensors))
        with pytest.raises(FileError, match=match):
            published.networks(path, layering)

    swapped = {**tensors, names[1]: tensors[names[2]], names[2]: tensors[names[1]]}
    swapped[names[1].replace("weight", "bias")] = tensors[names[2].replace("weight", "bias")]
    swapped[names[2].replace("weight", "bias")] = tensors[names[1].replace("weight", "bias")]
    refused(swapped, r"Linear 2 of .* has a weight of shape \(256, 128\), the paper's has \(128, 2")
    refused({**tensors, "latents": np.ones((9, 32), np.float32)}, "layer '' of the representation")
    refused({**tensors, "a.running_mean": np.ones(3, np.float32)}, "neither a Linear nor a LayerN")
    wrong = {**tensors, names[0]: np.full((256, 38), np.nan, np.float32)}
    refused(wrong, "'module.linear0.weight' of '.*' holds a number that is not finite")
    huge = {**tensors, names[0]: np.full((256, 38), 1e300)}
    refused(huge, "not finite in single precision")
    path = write(tmp_path / "two.pth", b"}(" + 2 * (text("a") + dictionary({})) + b"u", {})
    with pytest.raises(FileError, match="should hold one state dict and holds none"):
        published.networks(path, layering)


def hostile(target="") -> dict[str, tuple[bytes, str]]:
    """Pickles that must do nothing, with what the refusal says; some would make a file."""
    call = text(f"touch {target}") + b"\x85R"
    return {
        "system": (named("os", "system") + call, r"'os\.system'.*nothing was run"),
        "posix": (named("posix", "system") + call, r"'posix\.system'"),
        "stack global": (text("os") + text("system") + b"\x93" + call, r"'os\.system'"),
        "instance": (b"(" + text(f"touch {target}") + b"ios\nsystem\n", r"'os\.system'"),
        "eval": (named("builtins", "eval") + text("1") + b"\x85R", r"'builtins\.eval'"),
        "dotted": (named("torch", "serialization.load") + b")R", r"'torch\.serialization\.load'"),
        "other storage": (named("torch", "LongStorage"), r"'torch\.LongStorage'"),
        "new object": (named("collections", "OrderedDict") + b")\x81", "instruction NEWOBJ"),
        "extension": (b"\x82\x01", "instruction EXT1"),
        "call of a storage": (named("torch", "FloatStorage") + b")R", "damaged"),
        "dictionary of a call": (named("collections", "OrderedDict") + b"]\x85R", "damaged"),
        "cyclic": (b"}q\x00" + text("a") + b"h\x00s", "holds none"),
        "cyclic list": (b"]q\x00h\x00a", "holds none"),
        "missing memo": (b"h\x05", "damaged"),
        "empty stack": (b"R", "damaged"),
        "tuple as key": (b"})Ns", "damaged"),
        "text that ends early": (b"X\xff\xff\xff\x7fabc", "damaged"),
        "long text that ends early": (b"\x8d" + b"\xff" * 7 + b"\x7fabc", "damaged"),
        "long bytes": (b"\x8e" + b"\xff" * 7 + b"\x7fabc", "damaged"),
        "huge place in the memo": (b"}r\xff\xff\xff\xff0", "instruction POP"),
        "nested": (b"(" * 10000 + b"t" * 10000, "holds none"),
    }


@pytest.mark.parametrize("name", hostile())
def test_a_hostile_pickle_is_refused_and_nothing_runs(name, tmp_path):
    target = tmp_path / "made"
    program, match = hostile(target)[name]
    path = write(tmp_path / "hostile.pth", program, {})
    with pytest.raises(FileError, match=match) as caught:
        with TorchFile(path) as file:
            published.state_dict(file)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)
    assert not target.exists()


def test_the_hostile_file_of_the_test_would_run_in_a_plain_pickle(tmp_path):
    """The test above shows something: Python's pickle does run such a program."""
    program = writer.PROTO + named("os", "getpid") + b")R" + writer.STOP
    assert pickle.loads(program) == os.getpid()


def test_shapes_outside_the_storage_are_refused(tmp_path):
    values = np.ones(6, np.float32)
    cases = {
        "lies outside its storage": {"shape": (2, 3), "offset": 1},
        "lies outside": {"shape": (2, 3), "strides": (4, 1)},
        "wrong shape": {"shape": (2, 3), "strides": (-3, 1), "offset": 3},
        "has a wrong shape": {"shape": (-2, 3)},
        "at most 4194304 values": {"shape": (1 << 16, 1 << 16), "strides": (0, 0)},
    }
    for match, options in cases.items():
        program = dictionary({"a": tensor(values, "0", **options)})
        with TorchFile(write(tmp_path / "a.pth", program, {"0": values.tobytes()})) as file:
            with pytest.raises(FileError, match=match):
                file.array(file.content["a"], "a")
    for match, storages in {
        "has 20 bytes instead of 24": {"0": bytes(20)},
        "lacks the values 'a/data/0'": {},
    }.items():
        program = dictionary({"a": tensor(values, "0")})
        with TorchFile(write(tmp_path / "a.pth", program, storages)) as file:
            with pytest.raises(FileError, match=match):
                file.array(file.content["a"], "a")


def test_files_of_other_kinds_are_refused(params, files, tmp_path):
    data = files[0].read_bytes()

    def refused(content, match):
        path = tmp_path / "other.pth"
        if content is not None:
            path.write_bytes(content)
        with pytest.raises(FileError, match=match) as caught:
            TorchFile(path)
        assert "\n" not in str(caught.value)

    refused(data[: len(data) // 2], "truncated or damaged")
    refused(data[:2], "truncated or damaged")
    refused(b"", "is not a PyTorch file")
    refused(b"\x80\x02\x8a\nl\xfc\x9cF\xf9 j\xa8P\x19.\x80\x02M\xe9\x03.", r"before version 1\.6")
    refused(b"\x89HDF\r\n", "is not a PyTorch file")
    with pytest.raises(FileError, match="cannot read .* No such file"):
        TorchFile(tmp_path / "missing.pth")
    with pytest.raises(FileError, match="cannot read .* Is a directory"):
        TorchFile(tmp_path)
    with zipfile.ZipFile(tmp_path / "other.pth", "w") as archive:
        archive.writestr("words.txt", "no tensors")
    refused(None, "not one of torch.save")
    write(tmp_path / "other.pth", b"}", {}, order=b"big")
    refused(None, "big-endian")
    damaged = bytearray(data)
    damaged[len(data) // 2] ^= 1  # within a storage
    path = tmp_path / "other.pth"
    path.write_bytes(damaged)
    with pytest.raises(FileError, match="truncated or damaged"):
        published.networks(path, files[1])


def test_bombs_are_refused_in_little_memory(tmp_path):
    """A pickle of 200 MB behind 200 kB, and a file of 1 GB that takes no place on the disk."""
    with zipfile.ZipFile(tmp_path / "bomb.pth", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("bomb/data.pkl", bytes(200 << 20))
    with zipfile.ZipFile(tmp_path / "long.pth", "w") as archive:
        archive.writestr("long/data.pkl", bytes(MAX_PICKLE + 1))
    with (tmp_path / "sparse.pth").open("wb") as file:
        file.write(b"PK")
        file.truncate(1 << 30)
    code = (
        "import resource, sys\n"
        "from urushi.errors import FileError\n"
        "from urushi.paper.torch_file import TorchFile\n"
        "before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
        "for path in sys.argv[1:]:\n"
        "    try: TorchFile(path)\n"
        "    except FileError as error: print(error)\n"
        "print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) // 1024)\n"
    )
    names = [str(tmp_path / f"{name}.pth") for name in ("bomb", "long", "sparse")]
    run = subprocess.run(
        [sys.executable, "-c", code, *names], capture_output=True, text=True, check=True
    )
    bomb, long, sparse, grown = run.stdout.splitlines()
    assert "is compressed" in bomb
    assert "more than 1048576" in long
    assert "1073741824 bytes" in sparse
    assert int(grown) < 50  # MB
