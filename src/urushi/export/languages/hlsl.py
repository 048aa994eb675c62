"""HLSL and Slang, which share this subset."""

from urushi.export.languages.printer import Printer, c_kinds
from urushi.export.statements import Lookup, Table


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
    """Slang."""

    title = "Slang"
    usage = "Include this file in a Slang module."
