"""The shading languages: GLSL, HLSL with Slang, OSL and WGSL."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

from urushi.export.expressions import BOOL, COLOUR, FLOAT, INT, VECTOR
from urushi.export.languages.printer import Printer, c_kinds
from urushi.export.statements import Function, Lookup, Table, Variable


class Glsl(Printer):
    """GLSL, from OpenGL 3.3 and from OpenGL ES 3.0 (WebGL2)."""

    title = "GLSL"
    usage = (
        "Include this file after the line with the version (GLSL 3.30 or GLSL ES 3.00 and later) "
        "and, in GLSL ES, after `precision highp float;`."
    )
    kinds = c_kinds("vec3")

    def table(self, table: Table) -> list[str]:
        count = len(table.values)
        head = f"const float {self.table_name(table.name)}[{count}] = float[{count}]("
        return [head, *self.numbers(table.values), ");"]

    def fetched(self, lookup: Lookup, label: str, level: str | None) -> tuple[str, str, str]:
        result = self.kind(lookup.function.kind)
        place = "vec3(place, float(layer))"
        if level is None:
            head = f"{result} {label}(sampler2DArray texels, vec2 uv) {{"
            return head, "vec2 place", f"vec4 four = texture(texels, {place})"
        head = f"{result} {label}(sampler2DArray texels, vec2 uv, float {level}) {{"
        return head, "vec2 place", f"vec4 four = textureLod(texels, {place}, {level})"


class Hlsl(Printer):
    """HLSL, in the subset that Slang shares."""

    title = "HLSL"
    usage = "Include this file in a shader of shader model 5.0 or later."
    kinds = c_kinds("float3")

    def table(self, table: Table) -> list[str]:
        head = f"static const float {self.table_name(table.name)}[{len(table.values)}] = {{"
        return [head, *self.numbers(table.values), "};"]

    def splat(self, value: str) -> str:
        return f"({value}).xxx"

    two = "float2"

    def fetched(self, lookup: Lookup, label: str, level: str | None) -> tuple[str, str, str]:
        result = self.kind(lookup.function.kind)
        arguments = "Texture2DArray<float4> texels, SamplerState filtering, float2 uv"
        place = "float3(place, float(layer))"
        if level is None:
            sample = f"float4 four = texels.Sample(filtering, {place})"
            return f"{result} {label}({arguments}) {{", "float2 place", sample
        sample = f"float4 four = texels.SampleLevel(filtering, {place}, {level})"
        return f"{result} {label}({arguments}, float {level}) {{", "float2 place", sample


class Slang(Hlsl):
    title = "Slang"
    usage = "Include this file in a Slang module."


class Osl(Printer):
    """OSL, the Open Shading Language."""

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


class Wgsl(Printer):
    """WGSL, the language of WebGPU."""

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
