"""Python with NumPy: arrays of directions at once."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

from urushi.export.expressions import BOOL, COLOUR, FLOAT, INT, VECTOR
from urushi.export.languages.printer import WIDTH, Printer, broken
from urushi.export.proposal import SAMPLE
from urushi.export.statements import Function, Program, Statement, Structure, Table, Variable


class Python(Printer):
    """Python. Floats are arrays (..., 1), so that they broadcast against vectors (..., 3)."""

    title = "Python"
    usage = (
        "It needs NumPy. Directions are arrays (..., 3), results have the same leading dimensions. "
        "{sample} returns the pair (wo, density)."
    )
    comment = "#"
    kinds: ClassVar[Mapping[str, str]] = {
        FLOAT: "float",
        COLOUR: "colour",
        VECTOR: "vector",
        BOOL: "bool",
        INT: "int",
    }
    calls: ClassVar[Mapping[str, str]] = {
        "sqrt": "np.sqrt",
        "log": "np.log",
        "exp": "np.exp",
        "tanh": "np.tanh",
        "abs": "np.abs",
        "min": "np.minimum",
        "max": "np.maximum",
        "clamp": "np.clip",
        "cos": "np.cos",
        "sin": "np.sin",
    }
    components = ("[..., 0:1]", "[..., 1:2]", "[..., 2:3]")
    end = ""
    loop_end = ()

    def printed(self, program: Program) -> str:
        self._public = program.public
        return super().printed(program)

    def head(self, program: Program) -> list[str]:
        return [*super().head(program), "", "import numpy as np"]

    def function_name(self, label: str) -> str:
        return label if label in self._public else f"_{label}"

    def structure_name(self, label: str) -> str:
        return label

    def table_name(self, label: str) -> str:
        return f"_{label.upper()}"

    def structure(self, structure: Structure) -> list[str]:
        lines = ["", f"class {structure.name}:", f'    """{structure.note}"""']
        lines += ["", "    def __init__(self):"]
        for variable in structure.fields:
            value = "None" if variable.count is None else f"[None] * {variable.count}"
            note = f"  # {variable.note}" if variable.note else ""
            lines.append(f"        self.{variable.name} = {value}{note}")
        return lines

    def table(self, table: Table) -> list[str]:
        numbers = self.numbers(table.values)
        return [f"{self.table_name(table.name)} = np.array([", *numbers, "], np.float32)"]

    def function(self, function: Function) -> list[str]:
        arguments = ", ".join(variable.name for variable in function.arguments)
        lines = ["", f"def {self.function_name(function.name)}({arguments}):"]
        lines.append(f'    """{function.note}"""')
        if function.public:
            for variable in function.arguments:
                if variable.kind in (VECTOR, COLOUR):
                    lines.append(f"    {variable.name} = np.asarray({variable.name}, np.float32)")
        self._function = function
        return [*lines, *self.body(function.body, "    ")]

    def statement(self, statement: Statement) -> str:
        line = super().statement(statement)
        if statement.operation != "return" or not self._function.public:
            return line
        if self._function.kind == SAMPLE.name:
            direction, density = (f"{line}.{variable.name}" for variable in SAMPLE.fields)
            return f"{direction}, {density.removeprefix('return ')}[..., 0]"
        return f"{line}[..., 0]" if self._function.kind == FLOAT else line

    def wrapped(self, line: str) -> list[str]:
        stripped = line.lstrip()
        if len(line) <= WIDTH or stripped.startswith(self.comment):
            return [line]
        indent = " " * (len(line) - len(stripped))
        mark = "return " if stripped.startswith("return ") else " = "
        head, _, value = stripped.partition(mark)
        inner = indent + "    "
        return [f"{indent}{head}{mark}(", *broken(value, inner, inner), f"{indent})"]

    def loop_head(self, counter: str, count: int) -> str:
        return f"for {counter} in range({count}):"

    def let(self, variable: Variable, value: str) -> str:
        return f"{variable.name} = {value}"

    def empty(self, variable: Variable) -> str:
        if variable.count is not None:
            return f"{variable.name} = [None] * {variable.count}"
        return f"{variable.name} = {self.structure_name(variable.kind)}()"

    def colour(self, values: Sequence[float]) -> str:
        return f"np.array([{', '.join(map(self.number, values))}], np.float32)"

    def vector(self, components: Sequence[str]) -> str:
        if all(component[0].isdigit() for component in components):
            return f"np.array([{', '.join(components)}], np.float32)"
        arrays = f"np.broadcast_arrays({', '.join(components)})"
        return f"np.concatenate({arrays}, axis=-1)"

    def channels(self, values: Sequence[str]) -> str:
        """A colour of numbers; what a texture gives does not occur in Python."""
        return f"np.array([{', '.join(values)}], np.float32)"

    def splat(self, value: str) -> str:
        return f"({value}) * np.ones(3, np.float32)"

    def selected(self, condition: str, yes: str, no: str) -> str:
        return f"np.where({condition}, {yes}, {no})"
