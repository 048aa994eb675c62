"""HLSL and Slang, which share this subset."""

from urushi.export.languages.printer import Printer, c_kinds
from urushi.export.statements import Table


class Hlsl(Printer):
    """HLSL."""

    title = "HLSL"
    usage = "Include this file in a shader of shader model 5.0 or later."
    kinds = c_kinds("float3")

    def table(self, table: Table) -> list[str]:
        head = f"static const float {self.table_name(table.name)}[{len(table.values)}] = {{"
        return [head, *self.numbers(table.values), "};"]

    def splat(self, value: str) -> str:
        return f"({value}).xxx"


class Slang(Hlsl):
    """Slang."""

    title = "Slang"
    usage = "Include this file in a Slang module."
