"""OSL, the Open Shading Language."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

from urushi.export.expressions import BOOL, COLOUR, FLOAT, INT, VECTOR
from urushi.export.languages.printer import Printer
from urushi.export.statements import Function, Table


class Osl(Printer):
    """OSL."""

    title = "OSL"
    usage = (
        "Include this file in a shader. OSL renderers integrate closures and have none for these "
        "functions: they serve where a shader knows both directions."
    )
    kinds: ClassVar[Mapping[str, str]] = {
        FLOAT: "float",
        COLOUR: "color",
        VECTOR: "vector",
        BOOL: "int",
        INT: "int",
    }
    components = ("[0]", "[1]", "[2]")

    def outer_tables(self, function: Function) -> Sequence[Table]:
        return ()  # OSL has no constants outside functions

    def table(self, table: Table) -> list[str]:
        head = f"    float {self.table_name(table.name)}[{len(table.values)}] = {{"
        return [head, *self.numbers(table.values, " " * 8), "    };"]

    def function(self, function: Function) -> list[str]:
        lines = [*self.comments(function.note), self.signature(function)]
        for table in function.tables:
            lines += self.table(table)
        return [*lines, *self.body(function.body, "    "), "}"]
