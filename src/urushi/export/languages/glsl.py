"""GLSL, from OpenGL 3.3 and from OpenGL ES 3.0 (WebGL2)."""

from urushi.export.languages.printer import Printer, c_kinds
from urushi.export.statements import Table


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
