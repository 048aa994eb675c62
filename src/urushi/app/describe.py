"""Descriptions of materials, written as in Python: "conductor(alpha=0.2, r0=0.9)", or by name.

`materials.json` is a library of described materials. Indices of metals are taken from
Mitsuba. The index of brass and the colours of woods, pigments and dyes are estimates.
"""

import ast
import functools
import inspect
import json
import re
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

from urushi.errors import ParameterError


def makers() -> dict[str, Any]:
    """The functions of the Python interface that a description may call, by name."""
    from urushi.walk import bottoms, coat, slab  # lazily: it starts Dr.Jit

    return {"coat": coat, "slab": slab, **bottoms.MAKERS}


@functools.cache
def library() -> dict[str, str]:
    """The descriptions of the library by name."""
    return json.loads((files("urushi.app") / "materials.json").read_text(encoding="utf-8"))


def describe(text: str) -> Any:
    """Build the description of a bottom, or the Stack, that `text` describes.

    The text is a Python expression without the prefix `urushi.`; coats may be nested:
    "coat(conductor(alpha=0.2, r0=0.9), alpha=0.05, ior=1.5)". It may hold the functions of
    `makers`, numbers, tuples of numbers, and True or False for switches; nothing else is evaluated.
    A name of `library` stands for its description.
    """
    text = library().get(text.strip(), text)
    try:
        tree = ast.parse(text.strip(), mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise _refuse(text, "it is not a Python expression") from error
    if not isinstance(tree.body, ast.Call):
        raise _refuse(text, "it is neither a call nor a name of `urushi materials`")
    return _build(tree.body, text)


def is_description(text: str) -> bool:
    """Whether `text` is a call, or begins one of `makers`, or is in the library: no file's name."""
    calls, text = tuple(f"{maker}(" for maker in makers()), text.strip()
    is_call = re.fullmatch(r"[\w.]+\(.*\)", text, re.DOTALL) is not None
    return is_call or text.startswith(calls) or text in library()


def _build(node: ast.expr, text: str) -> Any:
    if not isinstance(node, ast.Call):
        return _number(node, text)
    known = makers()
    if not isinstance(node.func, ast.Name) or node.func.id not in known:
        raise _refuse(text, f"'{ast.unparse(node.func)}' is not one of {', '.join(known)}")
    maker = known[node.func.id]
    positional = [_build(argument, text) for argument in node.args]
    parameters = inspect.signature(maker)
    switches = [key for key, one in parameters.parameters.items() if isinstance(one.default, bool)]
    named: dict[str, Any] = {}
    for key, value in ((str(keyword.arg), keyword.value) for keyword in node.keywords):
        if key in named:
            raise _refuse(text, f"'{key}' is given twice")
        if key in switches and isinstance(value, ast.Constant) and isinstance(value.value, int):
            named[key] = bool(value.value)
        else:
            named[key] = _build(value, text)
    try:
        parameters.bind(*positional, **named)
    except TypeError as error:
        untyped = [p.replace(annotation=p.empty) for p in parameters.parameters.values()]
        call = f"{node.func.id}{inspect.Signature(untyped)}"
        raise _refuse(text, f"{error} in {call}") from error
    return maker(*positional, **named)


def _number(node: ast.expr, text: str) -> Any:
    try:
        value = ast.literal_eval(node)
    except (ValueError, TypeError, SyntaxError):
        value = None
    numbers = value if isinstance(value, tuple | list) else (value,)
    if not all(isinstance(x, int | float) and not isinstance(x, bool) for x in numbers):
        raise _refuse(text, f"'{ast.unparse(node)}' is neither one number nor three numbers")
    return value


def _refuse(text: str, reason: str) -> ParameterError:
    return ParameterError(
        f"cannot read the description '{text}': {reason}; "
        'write it as in Python, e.g. "coat(conductor(alpha=0.2, r0=0.9), alpha=0.05, ior=1.5)"'
    )


@dataclass(frozen=True)
class Materials:
    """List the materials of the library, with their descriptions.

    Every command that takes a description takes these names, too, as in
    `urushi view "vermilion urushi"`.

    Example: urushi materials
    """

    def run(self) -> int:
        for name, description in library().items():
            print(f"{name}\n    {description}")
        return 0
