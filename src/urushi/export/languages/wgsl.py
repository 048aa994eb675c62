"""WGSL, the language of WebGPU."""

from collections.abc import Mapping
from typing import ClassVar

from urushi.export.expressions import BOOL, COLOUR, FLOAT, INT, VECTOR
from urushi.export.languages.printer import Printer
from urushi.export.statements import Function, Lookup, Table, Variable


class Wgsl(Printer):
    """WGSL."""

    title = "WGSL"
    usage = "Put this file before the code that uses it: WGSL has no includes."
    kinds: ClassVar[Mapping[str, str]] = {
        FLOAT: "f32",
        COLOUR: "vec3f",
        VECTOR: "vec3f",
        BOOL: "bool",
        INT: "i32",
    }
    field_end = ","
    structure_end = "}"

    def declared(self, variable: Variable) -> str:
        kind = self.kind(variable.kind)
        if variable.count is not None:
            kind = f"array<{kind}, {variable.count}>"
        return f"{variable.name}: {kind}"

    def table(self, table: Table) -> list[str]:
        kind = f"array<f32, {len(table.values)}>"
        return [
            f"const {self.table_name(table.name)} = {kind}(",
            *self.numbers(table.values),
            ");",
        ]

    def signature(self, function: Function) -> str:
        arguments = ", ".join(map(self.declared, function.arguments))
        name = self.function_name(function.name)
        return f"fn {name}({arguments}) -> {self.kind(function.kind)} {{"

    def loop_head(self, counter: str, count: int) -> str:
        return f"for (var {counter} = 0; {counter} < {count}; {counter}++) {{"

    def let(self, variable: Variable, value: str) -> str:
        return f"let {variable.name} = {value};"

    def empty(self, variable: Variable) -> str:
        return f"var {self.declared(variable)};"

    def selected(self, condition: str, yes: str, no: str) -> str:
        return f"select({no}, {yes}, {condition})"

    two = "vec2f"

    def fetched(self, lookup: Lookup, label: str, level: str | None) -> tuple[str, str, str]:
        arguments = "texels: texture_2d_array<f32>, filtering: sampler, uv: vec2f"
        end = f" -> {self.kind(lookup.function.kind)} {{"
        if level is None:
            sample = "let four = textureSample(texels, filtering, place, layer)"
            return f"fn {label}({arguments}){end}", "let place", sample
        sample = f"let four = textureSampleLevel(texels, filtering, place, layer, {level})"
        return f"fn {label}({arguments}, {level}: f32){end}", "let place", sample
