"""The languages: GLSL, WGSL, HLSL with Slang, OSL, and Python with NumPy."""

from collections.abc import Sequence

from urushi.export.expressions import COLOUR, FLOAT, LAYERS, TEXTURE, VECTOR
from urushi.export.printer import Printer, broken, kinds
from urushi.export.proposal import SAMPLE
from urushi.export.rest import TextureForm
from urushi.export.statements import Function, Program, Statement, Structure, Variable


class Glsl(Printer):
    """GLSL, from OpenGL 3.3 and from OpenGL ES 3.0 (WebGL2)."""

    title = "GLSL"
    usage = (
        "Include this file after the line with the version (GLSL 3.30 or GLSL ES 3.00 and later) "
        "and, in GLSL ES, after `precision highp float;`."
    )
    kinds = kinds("vec2", "vec3", "vec4")
    forms = Printer.forms | {
        "splat": "vec3({})",
        TEXTURE: "highp sampler3D {}",
        "texel": "textureLod({}, {}, 0.0)",
        LAYERS: "sampler2DArray {}",
        "layer": "textureLod({}, vec3({}, {}, {}.0), 0.0)",
    }


class Hlsl(Printer):
    """HLSL, in the subset that Slang shares."""

    title = "HLSL"
    usage = "Include this file in a shader of shader model 5.0 or later."
    kinds = kinds("float2", "float3", "float4")
    forms = Printer.forms | {
        "splat": "({}).xxx",
        TEXTURE: "Texture3D<float4> {}, SamplerState filtering",
        "texel": "{}.SampleLevel(filtering, {}, 0.0)",
        LAYERS: "Texture2DArray<float4> {}, SamplerState filtering",
        "layer": "{}.SampleLevel(filtering, float3({}, {}, {}.0), 0.0)",
    }


class Slang(Hlsl):
    title = "Slang"
    usage = "Include this file in a Slang module."


class Osl(Printer):
    """OSL, the Open Shading Language. Few renderers have its 3D textures."""

    title = "OSL"
    usage = (
        "Include this file in a shader. OSL renderers integrate closures and have none for these "
        "functions: they serve where a shader knows both directions."
    )
    kinds = kinds("vector", "vector", "color", truth="int") | {COLOUR: "color"}
    components, rgb = ("[0]", "[1]", "[2]"), ""
    form = TextureForm(axes=2, numbers=3)
    forms = Printer.forms | {
        "splat": "color({})",
        TEXTURE: "string {}",
        "texel": 'texture({0}, {1}[0], {1}[1], "width", 0.0, "wrap", "clamp", "interp", "linear")',
    }


class Wgsl(Printer):
    """WGSL, the language of WebGPU."""

    title = "WGSL"
    usage = "Put this file before the code that uses it: WGSL has no includes."
    kinds = kinds("vec2f", "vec3f", "vec4f", "f32", "i32")
    structure_end = "}"
    forms = Printer.forms | {
        "variable": "{name}: {kind}",
        "array": "{name}: array<{kind}, {count}>",
        "function": "fn {name}({arguments}) -> {kind} {{",
        "field": "{},",
        "let": "let {name} = {value};",
        "empty": "var {};",
        "select": "select({2}, {1}, {0})",
        "splat": "vec3f({})",
        TEXTURE: "{}: texture_3d<f32>, filtering: sampler",
        "texel": "textureSampleLevel({}, filtering, {}, 0.0)",
        LAYERS: "{}: texture_2d_array<f32>, filtering: sampler",
        "layer": "textureSampleLevel({}, filtering, vec2f({}, {}), {}, 0.0)",
    }


#: Functions that have the same names in NumPy.
PLAIN = ("sqrt", "log", "exp", "tanh", "abs", "cos", "sin", "floor")

#: A 3D texture's hardware, in Python.
TEXEL_FUNCTION = '''

def _texel(texture, place):
    """Numbers (..., 4) of a texture (depth, height, width, 4), linear between its texels."""
    size = np.array(texture.shape[2::-1])
    at = np.clip(place * size.astype(np.float32) - np.float32(0.5), 0, size - 1)
    low = np.minimum(at.astype(int), size - 2)
    share, total = (at - low).astype(np.float32), 0
    for corner in np.ndindex(2, 2, 2):
        x, y, z = np.moveaxis(low + corner, -1, 0)
        weight = np.where(corner, share, 1 - share).prod(axis=-1, keepdims=True)
        total = total + weight * texture[z, y, x]
    return total'''


class Python(Printer):
    """Python. Floats are arrays (..., 1), so that they broadcast against vectors (..., 3)."""

    title = "Python"
    usage = (
        "It needs NumPy. Directions are arrays (..., 3), results have the same leading dimensions. "
        "{sample} returns the pair (wo, density)."
    )
    comment = "#"
    calls = {name: f"np.{name}" for name in PLAIN} | {
        "min": "np.minimum",
        "max": "np.maximum",
        "clamp": "np.clip",
    }
    components, rgb = tuple(f"[..., {i}:{i + 1}]" for i in range(4)), "[..., :3]"
    end = ""
    forms = Printer.forms | {
        "let": "{name} = {value}",
        "select": "np.where({}, {}, {})",
        "splat": "({}) * np.ones(3, np.float32)",
        "texel": "_texel({}, {})",
    }

    def printed(self, program: Program) -> str:
        self._public = program.public
        return super().printed(program)

    def head(self, program: Program) -> list[str]:
        lines = [*super().head(program), "", "import numpy as np"]
        return [*lines, *TEXEL_FUNCTION.splitlines()] if program.textured else lines

    def function_name(self, label: str) -> str:
        return label if label in self._public else f"_{label}"

    def structure_name(self, label: str) -> str:
        return label

    def structure(self, structure: Structure) -> list[str]:
        lines = ["", f"class {structure.name}:", f'    """{structure.note}"""']
        lines += ["", "    def __init__(self):"]
        for variable in structure.fields:
            value = "None" if variable.count is None else f"[None] * {variable.count}"
            note = f"  # {variable.note}" if variable.note else ""
            lines.append(f"        self.{variable.name} = {value}{note}")
        return lines

    def function(self, function: Function) -> list[str]:
        arguments = ", ".join(variable.name for variable in function.arguments)
        lines = ["", f"def {self.function_name(function.name)}({arguments}):"]
        lines.append(f'    """{function.note}"""')
        if function.public:
            for variable in function.arguments:
                if variable.kind in (VECTOR, COLOUR):
                    lines.append(f"    {variable.name} = np.asarray({variable.name}, np.float32)")
        self._function = function
        body = (x for x in function.body if x.operation != "leave")  # arrays have no branches
        return [*lines, *self.body(body)]

    def statement(self, statement: Statement) -> str:
        line = super().statement(statement)
        if statement.operation != "return" or not self._function.public:
            return line
        if self._function.kind == SAMPLE.name:
            direction, density = (f"{line}.{variable.name}" for variable in SAMPLE.fields)
            return f"{direction}, {density.removeprefix('return ')}[..., 0]"
        return f"{line}[..., 0]" if self._function.kind == FLOAT else line

    def split(self, code: str, indent: str) -> list[str]:
        mark = "return " if code.startswith("return ") else " = "
        head, _, value = code.partition(mark)
        inner = indent + "    "
        return [f"{indent}{head}{mark}(", *broken(value, inner, inner), f"{indent})"]

    def empty(self, variable: Variable) -> str:
        if variable.count is not None:
            return f"{variable.name} = [None] * {variable.count}"
        return f"{variable.name} = {self.structure_name(variable.kind)}()"

    def composed(self, kind: str, parts: Sequence[str]) -> str:
        computed = any("(" in part for part in parts)  # arrays (..., 1), not numbers or their names
        if not computed and (kind == COLOUR or all(part[0].isdigit() for part in parts)):
            return f"np.array([{', '.join(parts)}], np.float32)"
        return f"np.concatenate(np.broadcast_arrays({', '.join(parts)}), axis=-1)"


#: The printers by the names of their languages.
LANGUAGES: dict[str, type[Printer]] = {
    printer.__name__.lower(): printer for printer in (Glsl, Wgsl, Hlsl, Slang, Osl, Python)
}
