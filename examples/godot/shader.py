"""Writes material.shader, the example's material for Godot 3, and its table: shader.py [FOLDER].

A Godot shader adds the light of each lamp in `light()`, which needs f alone. The exported GLSL is
valid there but for four things, which are changed here: Godot 3.2 has no structures, prints numbers
with exponents and a minus before a negative number wrongly, and rounds all numbers to six digits.
"""

import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from material import lacquer

from urushi.app.export import write_table

TABLE = "uniform sampler3D rest_table;\n\n"

LIGHT = """
void light() {
    vec3 n = normalize(NORMAL);
    vec3 t = normalize(cross(n, abs(n.x) < 0.9 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0)));
    vec3 b = cross(n, t);
    vec3 wi = vec3(dot(VIEW, t), dot(VIEW, b), dot(VIEW, n));
    vec3 wo = vec3(dot(LIGHT, t), dot(LIGHT, b), dot(LIGHT, n));
    // LIGHT_COLOR is pi times the colour and the energy of the lamp.
    SPECULAR_LIGHT += urushi_f(wi, wo, rest_table) * max(wo.z, 0.0) * LIGHT_COLOR * ATTENUATION;
}
"""


def godot(glsl: str) -> str:
    """A spatial shader of the exported GLSL of an isotropic material."""
    f = glsl[glsl.index("vec3 urushi_f(") :]
    f = f[: f.index("\n}\n") + 3]
    f = re.sub(r"(\d+\.\d+)e-(\d+)", _without_exponent, f)
    f = re.sub(r"\(-(\d[\d.]*)\)", r"(0.0 - \1)", f)
    return "shader_type spatial;\n" + TABLE + f + LIGHT


def _without_exponent(number: re.Match) -> str:
    """A small number as a product, none of whose factors is rounded away."""
    thousandths, rest = divmod(int(number[2]), 3)
    factors = ["0.001"] * thousandths + [["0.1"], ["0.01"]][rest - 1] * (rest > 0)
    return "(" + " * ".join([number[1], *factors]) + ")"


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    if not folder.is_dir():
        sys.exit(f"there is no folder '{folder}'; give one that exists")
    material = lacquer()
    (folder / "material.shader").write_text(godot(material.shader("glsl")), encoding="utf-8")
    write_table(folder / "material.dds", material.shader_texture("glsl"))
