"""Formulas and constants of the networks as TypeScript, for the page's core, and its materials.

    python -m viewer.formulas

writes the files of `src/printed`, which are not under version control. The formulas are those of
`urushi.core` and `urushi.nets`, by the expressions of which `urushi export` prints shaders; what
has a fast form of its own in the page, the networks' layers, is not among them. Functions take
numbers, a direction as three of them, and put features into an array. `make viewer` and
`make test-page` run this script.
"""

import ast
import importlib
import itertools
import json
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from urushi.app.describe import describe, library
from urushi.app.page_files import cards_of
from urushi.checks import CoatParameters, Widths
from urushi.core import appearance, facets, fresnel, microfacet, mixture, stretched, table
from urushi.core.namespace import Components
from urushi.export import rest
from urushi.export.expressions import (
    BOOL,
    COLOUR,
    FLOAT,
    INT,
    VECTOR,
    Expression,
    call,
    name,
    vector,
)
from urushi.export.languages import Glsl
from urushi.export.lobe import lobe_f, passed
from urushi.export.lobe import transmittance as transmittance_function
from urushi.export.printer import PRIMARY, Printer, broken
from urushi.export.program import TABLE
from urushi.export.statements import Function, Variable, element, integer, namespace
from urushi.nets import features, lobe, proposal, transmittance

FOLDER = Path(__file__).parent / "src/printed"

LIBRARY_HEAD = """\
// Written by `python -m viewer.formulas` from the library of materials of Python. Do not edit it.

import type { BottomInAir, CoatInAir } from "../material/material";

/** A described material. */
interface Described {
  name: string;
  bottom: BottomInAir;
  coats: CoatInAir[];
  energyCompensation?: boolean;
}

export const LIBRARY: readonly Described[] = ["""

HEAD = """\
// Written by `python -m viewer.formulas` from the formulas of Python. Do not edit it.
"""

#: The kind of functions that return nothing but fill an array.
NOTHING = "void"


def camel(label: str) -> str:
    """A name of Python as one of TypeScript: sum_xy2 as sumXy2."""
    return re.sub(r"_([a-z0-9])", lambda found: found[1].upper(), label)


class TypeScript(Printer):
    """TypeScript in double precision. An argument that is a direction becomes three numbers."""

    title = "TypeScript"
    kinds: ClassVar[Mapping[str, str]] = {
        FLOAT: "number",
        VECTOR: "Vector",
        BOOL: "boolean",
        INT: "number",
        NOTHING: "void",
    }
    calls: ClassVar[Mapping[str, str]] = {
        label: f"Math.{label}"
        for label in ("sqrt", "log", "log1p", "exp", "abs", "min", "max", "cos", "sin")
    }

    def function_name(self, label: str) -> str:
        return camel(label)

    def _precise(self, value: Expression) -> tuple[str, int]:
        """Components of directions are arguments of their own."""
        if value.operation == "component":
            return f"{camel(value.arguments[0].detail)}{'XYZ'[value.detail]}", PRIMARY
        text, binding = super()._precise(value)
        return (camel(text), binding) if value.operation == "name" else (text, binding)

    def declared(self, variable: Variable) -> str:
        label = camel(variable.name)
        if variable.kind == VECTOR:
            return ", ".join(f"{label}{axis}: number" for axis in "XYZ")
        kind = "ArrayLike<number>" if variable.count else self.kinds[variable.kind]
        return f"{label}: {'Float64Array' if variable.name == 'out' else kind}"

    def comments(self, text: str) -> list[str]:
        return [f"/** {text} */"]

    def function(self, function: Function) -> list[str]:
        note, head, *body = super().function(function)
        for label in re.findall(r"(\w+): number[,)]", head):
            if not re.search(rf"\b{label}\b", "".join(body)):
                head = head.replace(f"{label}:", f"_{label}:")  # an argument that is not read
        return [note, *self.wrapped(head), *body]

    def signature(self, function: Function) -> str:
        arguments = ", ".join(map(self.declared, function.arguments))
        head = f"export function {camel(function.name)}({arguments})"
        return f"{head}: {self.kinds[function.kind]} {{"

    def let(self, variable: Variable, value: str) -> str:
        return f"const {camel(variable.name)} = {value};"

    def composed(self, kind: str, parts: Sequence[str]) -> str:
        return "{ " + ", ".join(f"{k}: {x}" for k, x in zip("xyz", parts, strict=True)) + " }"

    def number(self, value: float) -> str:
        return repr(int(value) if value == int(value) else value)


WI, WO, W = (Variable(label, VECTOR) for label in ("wi", "wo", "w"))
OUT, AT = Variable("out", FLOAT, 1), Variable("at", INT)


def floats(*names: str) -> tuple[Variable, ...]:
    """Arguments that are numbers."""
    return tuple(Variable(label, FLOAT) for label in names)


ALPHAS = floats("alpha_u", "alpha_v")


def argument(variable: Variable) -> Expression:
    """An argument inside its function."""
    return name(variable.name, variable.kind)


def components(variable: Variable) -> Components:
    """A direction inside its function."""
    w = argument(variable)
    return Components(w.x, w.y, w.z)


def returning(
    label: str,
    note: str,
    arguments: Sequence[Variable],
    formula: Callable[..., Any],
    kind: str = FLOAT,
) -> Function:
    """The function of a formula, which takes the arguments and a namespace."""
    function = Function(label, tuple(arguments), kind, note)
    result = formula(*map(_value, arguments), namespace(function))
    function.returns(vector(*result) if kind == VECTOR else result)
    return function


def filling(
    label: str, note: str, arguments: Sequence[Variable], formula: Callable[..., Iterable[Any]]
) -> Function:
    """The function that puts the numbers of a formula into `out`, from the place `at` on."""
    function = Function(label, (*arguments, OUT, AT), NOTHING, note)
    for step, value in enumerate(formula(*map(_value, arguments), namespace(function))):
        place = argument(AT)
        if step:
            place = Expression("+", INT, (integer(step), place))
        function.assign(element(argument(OUT), place), value)
    return function


def _value(variable: Variable) -> Any:
    return components(variable) if variable.kind == VECTOR else argument(variable)


def _clip(value: Any, low: float, high: float) -> Any:
    return call("min", call("max", value, low), high)


def functions() -> list[Function]:
    """The functions of the file."""
    schlick = returning(
        "schlick",
        "Schlick's term of factors at normal and at grazing incidence (Schlick 1994).",
        floats("normal", "grazing", "cosine"),
        lambda normal, grazing, cosine, xp: lobe.reflectance_of(
            (normal, grazing, None, None, None), cosine, xp
        ),
    )
    exact = returning(
        "fresnel",
        "Unpolarised reflectance of a smooth surface of index eta - i k (PBRT v3, 8.2.1).",
        floats("cosine", "eta", "k"),
        fresnel.exact,
    )
    found = [
        schlick,
        exact,
        returning(
            "facet_cosine",
            "Cosine between either direction and the half vector.",
            (WI, WO),
            lambda wi, wo, xp: microfacet.facet_cosine(microfacet.half_vector(wi, wo, xp), xp),
        ),
        filling(
            "medium",
            "Albedo and optical depth of a medium of thickness 1 by its appearance.",
            floats("color", "body", "body_color", "g"),
            lambda *values: appearance.medium(
                values[:3], values[3], values[4]._replace(clip=_clip)
            ),
        ),
        filling(
            "node_directions",
            "Directions wi and wo of the coordinates of a table of f.",
            floats("u", "v", "w"),
            lambda u, v, w, xp: itertools.chain(*table.node_components(u, v, w, xp)),
        ),
        returning(
            "coated_color",
            "Albedo, at the normal, of a coat over a Lambertian reflectance, its surface included.",
            floats("eta", "albedo", "sigma_t", "g", "reflectance"),
            lambda *values: appearance.coated_color(
                CoatParameters(None, *values[:4]), values[4], values[5]
            ),
        ),
        returning(
            "multiple_albedo",
            "Albedo of light that facets reflect more than once (Kulla and Conty 2017).",
            floats("fresnel_mean", "seen_mean"),
            lambda fresnel_mean, seen_mean, xp: facets.multiple_albedo(fresnel_mean, seen_mean),
        ),
        filling(
            "stretched_coordinates",
            "Coordinates in a table of f by the stretch s^2, and factors of the azimuth.",
            (*floats("stretch2"), WI, WO),
            lambda stretch2, wi, wo, xp: itertools.chain(
                *stretched.stretched(*_both_and_apart(wi, wo), stretch2, xp)
            ),
        ),
    ]
    return [*found, *_of_networks(), *_of_surfaces(schlick, exact)]


def _both_and_apart(wi: Components, wo: Components) -> tuple[Components, Components]:
    """wi + wo and wi - wo."""
    pairs = list(zip(wi, wo, strict=True))
    return Components(*(a + b for a, b in pairs)), Components(*(a - b for a, b in pairs))


def _of_networks() -> list[Function]:
    """The inputs of networks of two GGX widths, whose first are those of networks of one."""

    def normalised(how: features.Normalisation, columns: Any) -> list[Any]:
        pairs = zip(columns, how.constants, strict=True)
        return [(column - mean) * factor for column, (mean, factor) in pairs]

    def coat(alpha_u: Any, alpha_v: Any, *medium: Any) -> Any:
        columns = features.coat_columns(Widths(alpha_u, alpha_v), *medium)
        return normalised(features.COATS[2], columns)

    def lobe_columns(alpha_u: Any, alpha_v: Any, *values: Any) -> Any:
        *reflectances, xp = values
        columns = lobe.feature_columns([alpha_u, alpha_v], tuple(reflectances), xp)
        return normalised(lobe.FEATURES[2], columns)

    medium = floats("eta", "albedo", "sigma_t", "g")
    return [
        filling("coat_features", "The layerer's inputs of a coat.", (*ALPHAS, *medium), coat),
        filling(
            "lobe_features",
            "The networks' inputs of a lobe, by its reflectances at `LOBE.COSINES`.",
            (*ALPHAS, *floats("first", "second", "third")),
            lobe_columns,
        ),
    ]


def _of_surfaces(schlick: Function, exact: Function) -> list[Function]:
    """The functions for a surface of two GGX widths, which may be equal.

    They call those of Schlick's term and of the exact reflectance.
    """

    def reflectance(numbers: Any, cosine: Any) -> Any:
        normal, grazing, factor, eta, k = (element(numbers, i) for i in range(1, 6))
        return schlick(normal, grazing, cosine) + factor * exact(cosine, eta, k)

    def shape(*values: Any) -> Any:
        *given, wi, wo, xp = values
        above = (
            Components(w.x, w.y, xp.named(f"above_{label}", xp.positive(w.z)))
            for label, w in (("i", wi), ("o", wo))
        )
        wi, wo = above
        h = microfacet.half_vector(wi, wo, xp)
        return microfacet.lobe_shape(Widths(*given), wi, wo, h, xp)

    return [
        filling(
            "proposal_weights",
            "Weights of a proposal by `TERMS` of the code, its overlaps and its lobe's numbers.",
            (
                Variable("terms", FLOAT, proposal.TERMS),
                Variable("overlaps", FLOAT, len(proposal.ALPHAS)),
                Variable("numbers", FLOAT, len(lobe.NUMBERS[2])),
                *floats("cosine", "passed"),
            ),
            lambda terms, overlaps, numbers, cosine, passed, xp: proposal.weights(
                [element(terms, i) for i in range(proposal.TERMS)],
                [element(overlaps, i) for i in range(len(proposal.ALPHAS))],
                Widths(*(element(numbers, i) for i in lobe.WIDTH_PLACES[2])),
                partial(reflectance, numbers),
                cosine,
                xp,
                passed,
            ),
        ),
        returning(
            "transmittance",
            "The share of light that passes the topmost interface, for a direction.",
            (*ALPHAS, *floats("factor", "eta", "k"), W),
            lambda *values: transmittance.transmittance(
                Widths(*values[:2]), values[2:5], *values[5:]
            ),
        ),
        returning("lobe_shape", "The lobe [1/sr] of reflectance 1.", (*ALPHAS, WI, WO), shape),
        returning(
            "visible_normal",
            "Facet normal, of any length, that is visible from wi (Dupuy and Benyoub 2023).",
            (*ALPHAS, WI, *floats("u1", "u2")),
            lambda *values: microfacet.visible_normal(Widths(*values[:-4]), *values[-4:]),
            VECTOR,
        ),
        returning(
            "reflection_pdf",
            "Density [1/sr] of light mirrored by visible normals, and then up.",
            (*ALPHAS, WI, WO),
            lambda *values: mixture.reflection_pdf(Widths(*values[:-3]), *values[-3:]),
        ),
    ]


#: Constants of the file, by their modules; `core.table` is the object TABLE.
CONSTANTS: dict[str, str] = {
    "gallery.caddy": "NATSUME",
    "gallery.teapot": "BODY LID HANDLE SPOUT",
    "urushi.checks": "AIR ETA_RANGE MIN_ALPHA MIN_INDEX_STEP TRAINED_G",
    "urushi.core.albedos": "ROUGHNESSES COSINES TOTAL_CELLS COARSE FINE",
    "urushi.core.appearance": "WI WO",
    "urushi.core.facets": "MIRROR",
    "urushi.core.quadrature": "POLAR_NODES EDGE_NODES AZIMUTH_NODES MIN_TANGENT",
    "urushi.core.stretched": "FACTORS",
    "urushi.core.table": "SHAPE MIN_LOG MAX_LOG MIN_COSINE",
    "urushi.material.albedo_rule": "COSINES AZIMUTHS NODES",
    "urushi.material.energy": "MARGIN LEAST_ALBEDO LEAST_REST NO_FACTOR ROUNDS FACETS ROUGH_GAIN",
    "urushi.material.layer": "DEEPEST",
    "urushi.nets.basis": "EMPTY_GAIN",
    "urushi.nets.features": "COAT_FEATURES",
    "urushi.nets.layerer": "LEAST_GAIN",
    "urushi.nets.lobe": "NO_LOBE LOBE_FEATURES NUMBERS COSINES",
    "urushi.nets.mlp": "POLYNOMIALS",
    "urushi.nets.proposal": "ALPHAS TERMS LARGEST_STRETCH",
}


def constants(path: str, names: str) -> list[str]:
    """The object of a module's constants."""
    module = importlib.import_module(path)
    values = ", ".join(f"{label}: {_literal(getattr(module, label))}" for label in names.split())
    label = path.rpartition(".")[2].upper()
    *lines, last = broken(f"export const {label} = {{ {values} }}", "", "  ")
    # A line must not begin with `as`.
    return [f"/** Of `{path}` of Python. */", *lines, f"{last} as const;", ""]


def _literal(value: Any) -> str:
    """A value as TypeScript."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key}: {_literal(x)}" for key, x in value.items()) + " }"
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, (Sequence, np.ndarray)):
        return "[" + ", ".join(map(_literal, value)) + "]"
    if not math.isfinite(value):
        return "-Infinity" if value < 0 else "Infinity"
    return TypeScript("").number(float(value))


def text() -> str:
    """The file."""
    printer = TypeScript("")
    lines = [HEAD, "/** A direction, z the normal. */"]
    lines += ["export interface Vector {", *(f"  readonly {k}: number;" for k in "xyz"), "}", ""]
    for path, names in CONSTANTS.items():
        lines += constants(path, names)
    for function in functions():
        lines += [*printer.function(function), ""]
    return "\n".join(lines)


def shader_text() -> str:
    """The file of shader code."""
    printer = Glsl("material")
    functions = transmittance_function(), _f(1), _f(2)
    lines = (line for function in functions for line in printer.function(function))
    return "\n".join([HEAD, *lines, ""])


def _f(widths: int) -> Function:
    """f of a material of one GGX width or two by its lobe and the table of its rest."""
    lobe_numbers = Variable("numbers", COLOUR, len(lobe.NUMBERS[widths]))
    stretch = () if widths == 1 else floats("stretch")
    end, number = ("", "one GGX width") if widths == 1 else ("2", "two GGX widths")
    note = f"f [1/sr] of a material of {number} by its lobe and the table of its rest."
    function = Function(f"f{end}", (lobe_numbers, *stretch, TABLE, WI, WO), COLOUR, note)
    own = [element(argument(lobe_numbers), i) for i in range(lobe_numbers.count)]
    top = lobe_f(function, own, argument(WI), argument(WO))
    of = (
        rest.Rest(1)
        if widths == 1
        else rest.Rest(1 + stretched.FACTORS, stretch=argument(*stretch))
    )
    directions = argument(WI), argument(WO)
    value = rest.rest_f(function, of, Glsl.form, argument(TABLE), *directions)
    ways = zip(("passed_i", "passed_o"), directions, strict=True)
    passed_i, passed_o = (passed(function, own, w, label) for label, w in ways)
    function.returns(top + passed_i * passed_o * value)
    return function


def library_text() -> str:
    """The file of the library of materials, as cards of the page."""
    lines = [LIBRARY_HEAD]
    for material in library():
        cards = cards_of(describe(material))
        assert cards is not None, material
        layers = [_short(layer) for layer in (cards["bottom"], *cards["coats"])]
        looks = looks_of(library()[material])
        shown = cards | {
            "name": material[0].upper() + material[1:],
            "bottom": layers[0],
            "coats": [as_described(*pair) for pair in zip(layers[1:], looks, strict=True)],
        }
        lines.append(f"  {json.dumps(shown)},")
    return "\n".join([*lines, "];", ""])


def looks_of(description: str) -> list[dict[str, Any]]:
    """The named parameters of a description's coats, the topmost first."""
    looks = []
    node: Any = ast.parse(description).body[0]
    node = node.value
    while node.func.id == "coat":
        looks.append({str(word.arg): ast.literal_eval(word.value) for word in node.keywords})
        node = node.args[0]
    return looks


def as_described(card: dict[str, Any], look: dict[str, Any]) -> dict[str, Any]:
    """A coat by its appearance as it was given, in place of albedo and sigma_t."""
    kept = {key: value for key, value in card.items() if key not in ("albedo", "sigmaT")}
    names = (*appearance.LOOK, "thickness")
    given = {key: value for key, value in look.items() if key in names}
    medium = (appearance.look_of(look, "the coat's") or appearance.LOOK) | given
    return {**kept, **{camel(key): value for key, value in medium.items()}}


def _short(layer: dict[str, Any]) -> dict[str, Any]:
    """A layer with numbers of three decimals, one where those of the channels agree."""

    def one(value: Any) -> Any:
        if isinstance(value, str):
            return value
        numbers = [round(float(x), 3) for x in np.ravel(value)]
        return numbers if len(set(numbers)) > 1 else numbers[0]

    return {key: one(value) for key, value in layer.items()}


def files() -> dict[str, str]:
    """The texts of the files of `FOLDER` by their names."""
    return {
        "formulas.ts": text(),
        "material.glsl": shader_text(),
        "library.ts": library_text(),
    }


def main() -> None:
    """Write the files."""
    FOLDER.mkdir(exist_ok=True)
    for label, content in files().items():
        (FOLDER / label).write_text(content, encoding="utf-8")


if __name__ == "__main__":
    main()
