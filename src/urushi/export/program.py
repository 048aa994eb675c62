"""Programs: a material with known codes, and all materials of given weights."""

import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from urushi.core.stretched import FACTORS
from urushi.errors import ParameterError
from urushi.export import lobe as lobes
from urushi.export import proposal
from urushi.export.expressions import (
    COLOUR,
    FLOAT,
    LAYERS,
    TEXTURE,
    Expression,
    call,
    colour,
    colour_of,
    expression,
    name,
    select,
    vector,
)
from urushi.export.languages import LANGUAGES
from urushi.export.lobe import X_AXIS, Tangent, passed, texels_have_edges
from urushi.export.printer import Printer
from urushi.export.proposal import SAMPLE, WI, WO, Terms, U
from urushi.export.rest import Rest, TextureForm, rest_f, texture_shape
from urushi.export.statements import (
    Function,
    Program,
    Structure,
    Texels,
    Variable,
    element,
    fetch_functions,
    member,
)
from urushi.nets.proposal import TERMS
from urushi.nets.transmittance import has_edges
from urushi.nets.weights import Model

#: How directions and values are meant, in every file.
CONVENTIONS = (
    "Directions are unit vectors that point away from the surface, in a frame whose z axis is the "
    "normal. wi is where the viewer or the path comes from, wo where the light is. f is the BRDF "
    "[1/sr] for red, green and blue in linear light, without the cosine: the reflected radiance is "
    "the sum of f(wi, wo) * wo.z * radiance. It is positive, reciprocal, and zero where either "
    "direction is below the horizon.",
    "u holds three uniform random numbers in [0, 1). {sample} returns wo and its density [1/sr]; "
    "f * wo.z / density is the weight of the path. {pdf} returns the density of {sample} at any "
    "wo.",
)

#: Further conventions of two widths, and how a file for all materials turns one.
ANISOTROPIC = (
    "The x axis of the frame is the tangent of the shape. f is the same for the mirror images of "
    "wi and wo at the plane of the normal and the material's tangent, and at the plane across."
)
TURNED = (
    "A material's tangent is the x axis. To turn it, set tangent_x and tangent_y of the material "
    "to the cosine and the sine of the angle."
)

#: What a file for a texture leaves out if no texel needs it.
NO_EDGES = (
    "No texel has a topmost interface of a relative index below one. For codes that have one, {f} "
    "of this file is wrong."
)

#: Beginning of the names in templates.
PREFIX = "urushi"

#: The texture of ln f or of the basis.
TABLE = Variable("table", TEXTURE)

#: How its texture is used.
FILTERING = (
    "Its sampler filters linearly. Where the language separates samplers from textures, the "
    "sampler follows the texture."
)

#: The material of a file for all materials, and its field of two GGX widths.
MATERIAL, STRETCH = "Material", Variable("stretch", FLOAT, note="of half vectors")


def material_text(
    language: str,
    model: Model,
    latents: np.ndarray,
    prefix: str,
    rotation: float = 0.0,
    *,
    has_lobe: bool = True,
    has_rest: bool = True,
) -> str:
    """The file of one material.

    Args:
        language: one of `LANGUAGES`.
        latents: (C, size), C being 1 or 3: codes, by whose lobes f is evaluated and which are
            sampled.
        prefix: begins the names in the file.
        rotation: [degrees] by which the material's tangent is turned.
        has_lobe, has_rest: whether f has the lobe, and what the texture holds.
    """
    printer = _printer(language, prefix)
    if len(latents) not in (1, 3):
        raise ParameterError(
            f"the material has {len(latents)} channels; only materials of one or three can be "
            "exported"
        )
    terms = proposal.terms_of(model, [expression(float(x)) for x in latents.mean(axis=0)])
    own = latents[:, : model.arch.lobe]
    code = _Code(
        [colour(column) for column in own.T] if has_lobe else (),
        Rest(1 if model.widths == 1 else 1 + FACTORS, terms.stretch) if has_rest else None,
        terms,
        Tangent.of(rotation),
        bool(has_edges(np.vstack([own, own.mean(axis=0)])).any()),
    )
    note = [
        f"A material of Urushi as code, of the weights {model.fingerprint}.",
        f"Functions: {{f}}(wi, wo{', table' if has_rest else ''}), {{pdf}}(wi, wo) and "
        "{sample}(wi, u).",
        *_conventions(model),
    ]
    if code.rest:
        note.append(f"The table is a texture of this material: {_size(code.rest, printer.form)}")
    structures = (proposal.structure(model.widths), SAMPLE)
    return printer.printed(Program(note, structures, _functions(code, (), printer.form)))


def codes_text(language: str, model: Model, prefix: str, texels: Texels | None = None) -> str:
    """The file of all materials of weights; their codes are arguments.

    It reads the texture `rest.basis_texture`.

    texels: of a texture of codes that the file also reads.
    """
    printer = _printer(language, prefix)
    program = _codes_program(model, printer.form, texels)
    if texels is None:
        return printer.printed(program)
    if LAYERS not in printer.forms:
        able = ", ".join(x for x, other in LANGUAGES.items() if LAYERS in other.forms)
        raise ParameterError(
            f"exported {printer.title} code reads no latent textures; choose one of {able}"
        )
    note = [
        *program.note,
        "{fetch}(texels, uv) reads a material from the texture that belongs to this file: an array "
        f"of {texels.layers} layers, RGBA8 without gamma, whose first row is at v = 0. "
        f"{texels.filtering} Where the language separates samplers from textures, the sampler "
        "follows the texture.",
    ]
    if not texels_have_edges(texels):
        note.append(NO_EDGES)
    prepare, *_ = program.functions
    functions = [*program.functions, *fetch_functions(texels, prepare)]
    return printer.printed(Program(note, program.structures, functions))


def template_text(language: str, model: Model) -> str:
    """The file of a material whose codes are still to be filled in, for writers without Python.

    It is the file of `codes_text` with a function `material` that prepares the codes. The number
    of a code and a channel is written as a name, `code_0_red` for the first. If the weights are
    anisotropic, `code_tangent_x` and `code_tangent_y` are the cosine and the sine of the rotation.
    """
    printer = _printer(language)
    program = _codes_program(model, printer.form)
    prepare, *_ = program.functions
    made = Function("material", (), MATERIAL, "This material; make it once.", public=True)
    codes = made.declare("codes", COLOUR, model.arch.latent)
    for i in range(model.arch.latent):
        numbers = (name(f"code_{i}_{channel}", FLOAT) for channel in ("red", "green", "blue"))
        made.assign(element(codes, i), colour_of(*numbers))
    if model.widths == 1:
        made.returns(prepare(codes))
    else:
        prepared = made.declare("prepared", MATERIAL)
        made.assign(prepared, prepare(codes))
        for variable in lobes.FIELDS:
            made.assign(member(prepared, variable), name(f"code_{variable.name}", FLOAT))
        made.returns(prepared)
    note = (
        f"A material of Urushi as code, of the weights {model.fingerprint}.",
        "Functions: {material}(), once; then {f}(material, wi, wo, table), {pdf}(material, wi, wo) "
        "and {sample}(material, wi, u). {prepare}(codes) makes other materials.",
        *_conventions(model),
        f"{program.note[-1]} `urushi export` without a material writes it.",
    )
    return printer.printed(Program(note, program.structures, [*program.functions, made]))


def texture_form(language: str) -> TextureForm:
    """What a language's textures of ln f are."""
    return _printer(language).form


def _printer(language: str, prefix: str = PREFIX) -> Printer:
    """The printer; a ParameterError if it is unknown, or if names cannot begin with the prefix."""
    if language not in tuple(LANGUAGES):
        raise ParameterError(
            f"there is no language '{language}'; choose one of {', '.join(LANGUAGES)}"
        )
    names = r"(?!gl_)([A-Za-z][A-Za-z0-9]*)(_[A-Za-z0-9]+)*"
    if not (isinstance(prefix, str) and re.fullmatch(names, f"{prefix}_f")):
        raise ParameterError(
            f"'{prefix}' is not a valid prefix of function names; use letters, digits and single "
            "underscores between them, beginning with a letter, and not the reserved gl"
        )
    return LANGUAGES[language](prefix)


class _Code(NamedTuple):
    """What a material's functions need of its codes."""

    lobe: Sequence[Expression]  # the numbers of its lobe; empty without one
    rest: Rest | None
    terms: Terms  # of the proposal
    tangent: Tangent
    has_edges: bool  # whether the rest is multiplied by T


def _functions(code: _Code, given: tuple[Variable, ...], form: TextureForm) -> list[Function]:
    """f, pdf and sample of a material, each after the functions that it calls.

    given: arguments before the directions.
    """
    own, tangent = [variable.value for variable in given], code.tangent

    def inside(body: Function) -> tuple[Expression, Expression]:
        """wi and wo in the frame of the tangent."""
        wi = tangent.inside(body, WI.value, "turned_i")
        return wi, tangent.inside(body, WO.value, "turned_o")

    arguments = (*given, WI, WO, TABLE) if code.rest else (*given, WI, WO)
    f = Function("f", arguments, COLOUR, "The BRDF [1/sr] without the cosine.", public=True)
    wi, wo = inside(f)
    value = lobes.lobe_f(f, code.lobe, wi, wo) if code.lobe else expression(0.0)
    if code.rest:
        rest = rest_f(f, code.rest, form, TABLE.value, wi, wo)
        if code.has_edges and code.lobe:
            f.note_line("The rest passes the interface in both ways.")
            passed_i = passed(f, code.lobe, wi, "passed_i")
            rest = passed_i * passed(f, code.lobe, wo, "passed_o") * rest
        value = value + rest
    f.returns(select(call("min", wi.z, wo.z) > 0.0, value, 0.0))

    made = Function("proposal", (*given, WI), "Proposal", "The proposal for wi.")
    seen = passed(made, code.terms.lobe, WI.value) if code.has_edges else 1.0
    made.returns(proposal.fill(made, code.terms, WI.value, seen))
    sampling = _, density_of, _, draw = proposal.functions(len(lobes.alphas_of(code.terms.lobe)))
    note = "The density [1/sr] of `sample` at wo."
    pdf = Function("pdf", (*given, WI, WO), FLOAT, note, public=True)
    wi, wo = inside(pdf)
    pdf.returns(density_of(made(*own, wi), wi, wo))

    note = "A direction, about in proportion to f and its cosine; below the horizon density 0."
    sample = Function("sample", (*given, WI, U), SAMPLE.name, note, public=True)
    wi, up = tangent.inside(sample, WI.value, "turned_i"), vector(0.0, 0.0, 1.0)
    raised = sample.let("raised", select(wi.z > 0.0, wi, up))
    mixture = sample.let("mixture", made(*own, raised))
    drawn = sample.let("drawn", draw(mixture, raised, U.value))
    result = sample.declare("result", SAMPLE.name)
    outside = tangent.outside(sample, drawn, "outside")
    density = density_of(mixture, raised, drawn)
    direction, its_density = (member(result, variable) for variable in SAMPLE.fields)
    sample.assign(direction, select(wi.z > 0.0, outside, up))
    sample.assign(its_density, select(wi.z > 0.0, density, 0.0))
    sample.returns(result)
    called = [lobes.transmittance()] if code.has_edges else []
    return [*called, f, made, *sampling, pdf, sample]


def _conventions(model: Model) -> tuple[str, ...]:
    """How directions and values are meant in a file."""
    return CONVENTIONS if model.widths == 1 else (*CONVENTIONS, ANISOTROPIC)


def _size(rest: Rest, form: TextureForm) -> str:
    """What a texture is, in sentences."""
    size = " x ".join(map(str, reversed(texture_shape(rest.texels, form))))
    return f"{size} texels of half floats, {form.numbers} each. {FILTERING}"


def _codes_program(model: Model, form: TextureForm, texels: Texels | None = None) -> Program:
    """The program of all materials, whose codes are arguments; its first function is `prepare`.

    form: of the textures of its language. texels: that the codes come from, if these are known.
    """
    arch = model.arch
    structure = Structure(
        MATERIAL,
        (
            Variable("codes", COLOUR, arch.latent, "the lobe, and factors of the basis"),
            Variable("mean_lobe", FLOAT, arch.lobe, "that directions are drawn by"),
            Variable("terms", FLOAT, TERMS, "of the energies of the proposal's lobes"),
            *((STRETCH, *lobes.FIELDS) if arch.widths == 2 else ()),
        ),
        "A material. `prepare` makes it.",
    )
    material = Variable("material", MATERIAL)
    codes, lobe, energies, *others = (member(material.value, x) for x in structure.fields)
    numbers = [element(codes, i) for i in range(arch.latent)]
    terms = Terms(
        [element(lobe, i) for i in range(arch.lobe)],
        [element(energies, i) for i in range(TERMS)],
        proposal.overlaps_of(model),
        others[0] if others else None,
    )
    rest = Rest(
        -(-arch.functions // form.numbers),
        stretch=terms.stretch,
        code=numbers[arch.lobe : arch.lobe + arch.functions],
        factors=np.delete(arch.factors, 1).tolist(),
    )
    edges = texels is None or texels_have_edges(texels)
    code = _Code(numbers[: arch.lobe], rest, terms, Tangent(*others[1:] or X_AXIS), edges)
    note = (
        f"All materials of Urushi's weights {model.fingerprint} as code; the latent codes of a "
        "material are arguments.",
        f"Functions: {{prepare}}(codes), once for the {arch.latent} numbers of a material's codes, "
        "each for red, green and blue; then {f}(material, wi, wo, table), {pdf}(material, wi, wo) "
        "and {sample}(material, wi, u).",
        *_conventions(model),
        *((TURNED,) if arch.widths == 2 else ()),
        f"The table is the texture of the basis, for all materials: {_size(rest, form)}",
    )
    structures = (structure, proposal.structure(arch.widths), SAMPLE)
    functions = [_prepare(model, structure), *_functions(code, (material,), form)]
    return Program(note, structures, functions)


def _prepare(model: Model, structure: Structure) -> Function:
    """The function that computes from codes what f and the proposal need."""
    latent = model.arch.latent
    codes = Variable("codes", COLOUR, latent)
    note = f"A material of its codes, {latent} numbers for red, green and blue."
    function = Function("prepare", (codes,), MATERIAL, note, public=True)
    numbers = [element(codes.value, i) for i in range(latent)]
    made = function.declare("made", MATERIAL)
    stored, lobe, terms, *others = (member(made, variable) for variable in structure.fields)

    def fill(array: Expression, values: Sequence[Expression]) -> None:
        for i, value in enumerate(values):
            function.assign(element(array, i), value)

    fill(stored, numbers)
    function.note_line("Directions are drawn by the mean code of the channels.")
    mean = [
        function.let(f"mean{i}", (number.x + number.y + number.z) * (1.0 / 3.0))
        for i, number in enumerate(numbers)
    ]
    found = proposal.terms_of(model, mean)
    fill(lobe, found.lobe)
    fill(terms, found.rest)
    if found.stretch is not None:
        for target, value in zip(others, (found.stretch, *X_AXIS), strict=True):
            function.assign(target, value)
    function.returns(made)
    return function
