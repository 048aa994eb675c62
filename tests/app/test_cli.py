"""The command line: help with examples, one sentence for an error, and exit codes."""

import os
import shlex
import signal
import subprocess
import sys
import time

import pytest

import urushi
from urushi.app import cli
from urushi.app.doctor import Doctor
from urushi.errors import ParameterError


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


def test_help_lists_every_command(capsys):
    for arguments in ([], ["--help"]):
        with pytest.raises(SystemExit) as caught:
            cli.main(arguments)
        assert caught.value.code == 0
        text = capsys.readouterr().out
        for name, (_, summary) in cli.COMMANDS.items():
            assert name in text
            assert summary in " ".join(text.split())


def test_version(capsys):
    assert cli.main(["--version"]) == 0
    assert capsys.readouterr().out.strip() == urushi.__version__


@pytest.mark.parametrize("arguments", [["polish"], ["render"], ["train", "--colour", "red"]])
def test_what_cannot_be_parsed(arguments, capsys):
    with pytest.raises(SystemExit) as caught:
        cli.main(arguments)
    assert caught.value.code == 2
    assert "Traceback" not in capsys.readouterr().err


def test_a_users_error_is_one_sentence(monkeypatch, capsys):
    def fail(self):
        raise ParameterError("alpha is 7; it must be a GGX width in [0.01, 1]")

    monkeypatch.setattr(Doctor, "run", fail)
    assert cli.main(["doctor"]) == 2
    captured = capsys.readouterr()
    assert captured.err == "urushi: alpha is 7; it must be a GGX width in [0.01, 1]\n"
    assert captured.out == ""


def test_ctrl_c_ends_a_command_that_does_not_return_to_python(tmp_path):
    """At once, and without the temporary file of a writer. The exception has no effect here."""
    code = (
        "import signal, sys, time, urushi_command\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "from urushi.app.doctor import Doctor\n"
        "from urushi.files import atomic_write\n"
        "path, sys.argv[1:] = sys.argv[1], ['doctor']\n"
        "def wait(self):\n"
        "    with atomic_write(path):\n"
        "        print('ready', flush=True)\n"
        "        while True:\n"
        "            try: time.sleep(60)\n"
        "            except KeyboardInterrupt: pass\n"
        "Doctor.run = wait\n"
        "sys.exit(urushi_command.main())"
    )
    command = [sys.executable, "-c", code, str(tmp_path / "file.txt")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as p:
        assert p.stdout.readline() == "ready\n"
        assert len(list(tmp_path.iterdir())) == 1
        begin = time.monotonic()
        p.send_signal(signal.SIGINT)
        _, errors = p.communicate(timeout=120)
    assert p.returncode == 130
    assert time.monotonic() - begin < 30  # half a second on an idle machine; the sleep takes 60
    assert errors == "urushi: interrupted; nothing half-written was left behind\n"
    assert not list(tmp_path.iterdir())


def test_ctrl_c_while_python_imports():
    code = (
        "import signal, sys, urushi_command\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "class Interrupts:\n"
        "    def find_spec(self, name, *_):\n"
        "        if name == 'urushi': signal.raise_signal(signal.SIGINT)\n"
        "sys.meta_path.insert(0, Interrupts())\n"
        "sys.exit(urushi_command.main())"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert run.returncode == 130
    assert run.stderr == "urushi: interrupted; nothing half-written was left behind\n"


def test_the_script_imports_little():
    """A command does not import packages that only another command needs."""
    code = (
        "import sys; from urushi.app import cli\n"
        "for name in ('jax', 'matplotlib', 'distributed', 'urushi.walk',"
        " 'urushi.nets'):\n"
        "    assert name not in sys.modules, name"
    )
    run = subprocess.run([sys.executable, "-c", code], env=os.environ, capture_output=True)
    assert run.returncode == 0, run.stderr.decode()


def test_a_closed_output_pipe_ends_the_command_silently():
    code = (
        "import sys\n"
        "from urushi.app import cli\n"
        "from urushi.app.doctor import Doctor\n"
        "Doctor.run = lambda self: print('all is well') or 0\n"
        "sys.exit(cli.main(['doctor']))"
    )
    command = [sys.executable, "-c", code]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait(timeout=120) == cli.OUTPUT_CLOSED
