"""GLSL, from OpenGL 3.3 and from OpenGL ES 3.0 (WebGL2)."""

from urushi.export.languages.printer import Printer, c_kinds
from urushi.export.statements import Lookup, Table


class Glsl(Printer):
    """GLSL."""

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
