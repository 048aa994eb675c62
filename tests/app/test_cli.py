"""The command line: help with examples, one sentence for an error, and exit codes."""

import os
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path
from unittest import mock

import pytest

import urushi
from urushi.app import cli
from urushi.app.doctor import Doctor

#: A device that is always full, on Linux.
FULL = Path("/dev/full")


@pytest.mark.parametrize("name", cli.COMMANDS)
def test_help_explains_and_its_example_parses(name, capsys):
    with pytest.raises(SystemExit) as caught:
        cli.main([name, "--help"])
    assert caught.value.code == 0
    assert f"Example: urushi {name}" in capsys.readouterr().out
    command = cli.COMMANDS[name][0]
    program, *arguments = shlex.split(command.__doc__.split("Example: ")[1])
    assert program == "urushi"
    assert isinstance(cli.parse(arguments), command)


def test_help_lists_every_command_and_version_is_the_packages(capsys):
    for arguments in ([], ["--help"]):
        with pytest.raises(SystemExit) as caught:
            cli.main(arguments)
        assert caught.value.code == 0
        text = capsys.readouterr().out
        for name, (_, summary) in cli.COMMANDS.items():
            assert name in text
            assert summary in " ".join(text.split())
    assert cli.main(["--version"]) == 0
    assert capsys.readouterr().out.strip() == urushi.__version__


@pytest.mark.parametrize("arguments", [["polish"], ["render"], ["train", "--colour", "red"]])
def test_what_cannot_be_parsed(arguments, capsys):
    with pytest.raises(SystemExit) as caught:
        cli.main(arguments)
    assert caught.value.code == 2
    assert "Traceback" not in capsys.readouterr().err


def process(*lines: str, **options) -> subprocess.Popen:
    """Python with lines of code, in which a command can be interrupted, and its output as text."""
    head = "import signal, sys\nsignal.signal(signal.SIGINT, signal.default_int_handler)\n"
    command = [sys.executable, "-c", head + "\n".join(lines)]
    pipes = dict.fromkeys(("stdout", "stderr"), subprocess.PIPE)
    return subprocess.Popen(command, text=True, **pipes, **options)


@pytest.mark.parametrize("closed", ["", "sys.stdout = None"])
def test_ctrl_c_ends_a_command_that_does_not_return_to_python(closed, tmp_path):
    """At once, and without the temporary file of a writer. The exception has no effect here.

    Also where standard output is closed.
    """
    with process(
        "import time, urushi_command",
        "from urushi.app.doctor import Doctor",
        "from urushi.files import atomic_write",
        "sys.argv[1:] = ['doctor']",
        "def wait(self):",
        "    with atomic_write('file.txt'):",
        "        print('ready', flush=True)",
        f"        {closed}",
        "        while True:",
        "            try: time.sleep(60)",
        "            except KeyboardInterrupt: pass",
        "Doctor.run = wait",
        "sys.exit(urushi_command.main())",
        cwd=tmp_path,
    ) as run:
        assert run.stdout.readline() == "ready\n"
        assert len(list(tmp_path.iterdir())) == 1
        begin = time.monotonic()
        run.send_signal(signal.SIGINT)
        _, errors = run.communicate(timeout=120)
    assert run.returncode == 130
    assert time.monotonic() - begin < 30  # half a second on an idle machine; the sleep takes 60
    assert errors == "urushi: interrupted; nothing half-written was left behind\n"
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("kind", [RuntimeError, SystemError])
def test_ctrl_c_that_another_error_wraps(kind, monkeypatch, capsys):
    """As from an import that Mitsuba does in `mi.set_variant`."""

    def run(self):
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as interrupt:
            raise kind("an exception was set") from interrupt

    monkeypatch.setattr(Doctor, "run", run)
    assert cli.main(["doctor"]) == 130
    assert capsys.readouterr().err.startswith("urushi: interrupted; nothing half-written")


@pytest.mark.parametrize("module", ["threading", "urushi"])  # the first import and the longest
def test_ctrl_c_while_python_imports(module):
    run = process(
        "import urushi_command",
        "class Interrupts:",
        "    def find_spec(self, name, *_):",
        f"        if name == '{module}': signal.raise_signal(signal.SIGINT)",
        "sys.meta_path.insert(0, Interrupts())",
        "sys.exit(urushi_command.main())",
    )
    assert run.communicate()[1] == "urushi: interrupted; nothing half-written was left behind\n"
    assert run.returncode == 130


def test_the_script_imports_little():
    """A command does not import packages that only another command needs."""
    run = process(
        "from urushi.app import cli",
        "for name in ('jax', 'matplotlib', 'distributed', 'urushi.walk', 'urushi.nets'):",
        "    assert name not in sys.modules, name",
    )
    assert run.communicate() == ("", "")


def test_a_closed_output_pipe_ends_the_command_silently():
    with process(
        "from urushi.app import cli",
        "from urushi.app.doctor import Doctor",
        "Doctor.run = lambda self: print('all is well') or 0",
        "sys.exit(cli.main(['doctor']))",
    ) as run:
        run.stdout.close()
        assert run.stderr.read() == ""
        assert run.wait(timeout=120) == cli.OUTPUT_CLOSED


@pytest.mark.skipif(not FULL.exists(), reason="needs a device that is full")
@pytest.mark.parametrize("argument", ["materials", "--help"])
def test_a_full_disk_under_standard_output_is_one_sentence(argument):
    command = [sys.executable, "-m", "urushi_command", argument]
    with FULL.open("w") as full:
        run = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True)
    assert run.returncode == cli.FAILURE
    assert run.stderr.startswith("urushi: cannot write to standard output: No space left")
    assert run.stderr.count("\n") == 1


@pytest.mark.parametrize("arguments", [["--help"], ["simulate", "diffuse(0.5)"]])
def test_output_in_an_encoding_without_some_characters(arguments):
    command = [sys.executable, "-m", "urushi_command", *arguments]
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    run = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert (run.returncode, run.stderr) == (0, "")
    assert "\\" in run.stdout


def test_a_file_that_may_not_be_looked_at_is_one_sentence(monkeypatch, capsys):
    """Also where no command expects it; so is a lack of memory."""
    private = PermissionError(13, "Permission denied", "/private/file")
    for failure, sentence in (
        (private, "cannot use '/private/file': Permission denied; check the path and its perm"),
        (MemoryError(), "this machine has too little memory; ask for fewer pixels"),
    ):
        monkeypatch.setattr(Doctor, "run", mock.Mock(side_effect=failure))
        assert cli.main(["doctor"]) == cli.FAILURE
        output, error = capsys.readouterr()
        assert error.startswith(f"urushi: {sentence}") and error.count("\n") == 1 and not output


def test_a_command_without_standard_error_works(tmp_path):
    """With a progress bar and with an error, which go nowhere."""
    for sources, code in ((["diffuse(0.5)", "diffuse(0.6)"], 0), (["diffuse(2)"], cli.FAILURE)):
        command = [sys.executable, "-m", "urushi_command", "encode", *sources, "-o", tmp_path / "a"]
        closed = ["/bin/sh", "-c", 'exec "$@" 2>&-', "sh", *map(str, command)]
        run = subprocess.run(closed, capture_output=True, text=True)
        assert run.returncode == code and (run.stdout == "") == (code != 0)


def test_a_command_without_standard_output_prints_nothing(monkeypatch, capsys):
    monkeypatch.setattr(sys, "stdout", None)  # as Python sets it for `>&-` in a shell
    assert cli.main(["materials"]) == 0
    assert capsys.readouterr() == ("", "")
