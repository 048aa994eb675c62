"""Programs: a material with known codes, and all materials of given weights."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from urushi.core.stretched import FACTORS
from urushi.core.table import Knots
from urushi.errors import ParameterError
from urushi.export import proposal, transmittance
from urushi.export.expressions import (
    COLOUR,
    FLOAT,
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
from urushi.export.lobe import FIELDS, X_AXIS, Tangent, alphas_of, lobe_f
from urushi.export.proposal import SAMPLE, WI, WO, Terms, U, argument
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
from urushi.export.transmittance import passed, texels_have_edges
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
    knots: Knots = (),
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
        knots: of the table of ln f, which the texture `rest.own_texture` holds.
        has_lobe, has_rest: whether f has the lobe, and what the texture holds.
    """
    check(language, prefix)
    if len(latents) not in (1, 3):
        raise ParameterError(
            f"the material has {len(latents)} channels; only materials of one or three can be "
            "exported"
        )
    terms = proposal.terms_of(model, [expression(float(x)) for x in latents.mean(axis=0)])
    rest = Rest(1 if model.widths == 1 else 1 + FACTORS, knots, terms.stretch) if has_rest else None
    lobes = latents[:, : model.arch.lobe]
    code = _Code(
        [colour(column) for column in lobes.T] if has_lobe else (),
        rest,
        terms,
        Tangent.of(rotation),
        bool(has_edges(np.vstack([lobes, lobes.mean(axis=0)])).any()),
    )
    printer = LANGUAGES[language](prefix)
    note: tuple[str, ...] = (
        f"A material of Urushi as code, of the weights {model.fingerprint}.",
        f"Functions: {{f}}(wi, wo{', table' if rest else ''}), {{pdf}}(wi, wo) and "
        "{sample}(wi, u).",
        *_conventions(model),
    )
    if rest:
        note = *note, f"The table is a texture of this material: {_size(rest, printer.form)}"
    structures = (proposal.structure(model.widths), SAMPLE)
    return printer.printed(Program(note, structures, _functions(code, (), printer.form)))


def _size(rest: Rest, form: TextureForm) -> str:
    """What a texture is, in sentences."""
    size = " x ".join(map(str, reversed(texture_shape(rest.texels, form))))
    return f"{size} texels of half floats, {form.numbers} each. {FILTERING}"


def codes_text(language: str, model: Model, prefix: str, texels: Texels | None = None) -> str:
    """The file of all materials of weights; their codes are arguments.

    It reads the texture `rest.basis_texture`.

    texels: of a texture of codes that the file also reads.
    """
    check(language, prefix)
    printer = LANGUAGES[language](prefix)
    if texels and not printer.textures.layers:
        able = [name for name, printer in LANGUAGES.items() if printer.textures.layers]
        raise ParameterError(
            f"exported {printer.title} code reads no latent textures; choose one of "
            + ", ".join(able)
        )
    return printer.printed(codes_program(model, printer.form, texels))


def template_text(language: str, model: Model) -> str:
    """The file of a material whose codes are still to be filled in, for writers without Python.

    It is the file of `codes_text` with a function `material` that prepares the codes. The number
    of a code and a channel is written as a name, `code_0_red` for the first. If the weights are
    anisotropic, `code_tangent_x` and `code_tangent_y` are the cosine and the sine of the rotation.
    """
    printer = LANGUAGES[language](PREFIX)
    program = codes_program(model, printer.form)
    prepare = next(function for function in program.functions if function.name == "prepare")
    made = Function("material", (), MATERIAL, "This material; make it once.", public=True)
    codes = made.array("codes", COLOUR, model.arch.latent)
    for i in range(model.arch.latent):
        numbers = (name(f"code_{i}_{channel}", FLOAT) for channel in ("red", "green", "blue"))
        made.assign(element(codes, i), colour_of(*numbers))
    if model.widths == 1:
        made.returns(prepare(codes))
    else:
        prepared = made.structure("prepared", MATERIAL)
        made.assign(prepared, prepare(codes))
        for variable in FIELDS:
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
    check(language, PREFIX)
    return LANGUAGES[language].form


def check(language: str, prefix: str) -> None:
    """Raise a ParameterError if there is no such language, or names cannot begin with a prefix."""
    if language not in LANGUAGES:
        raise ParameterError(
            f"there is no language '{language}'; choose one of {', '.join(LANGUAGES)}"
        )
    if not (prefix.isascii() and prefix.isidentifier()) or "__" in prefix or prefix[0] == "_":
        raise ParameterError(
            f"'{prefix}' is not a valid prefix of function names; use letters, digits and single "
            "underscores, beginning with a letter"
        )


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
    own, tangent = [argument(variable) for variable in given], code.tangent

    def inside(body: Function) -> tuple[Expression, Expression]:
        """wi and wo in the frame of the tangent."""
        wi = tangent.inside(body, argument(WI), "turned_i")
        return wi, tangent.inside(body, argument(WO), "turned_o")

    arguments = (*given, WI, WO, TABLE) if code.rest else (*given, WI, WO)
    f = Function("f", arguments, COLOUR, "The BRDF [1/sr] without the cosine.", public=True)
    wi, wo = inside(f)
    value = lobe_f(f, code.lobe, wi, wo) if code.lobe else expression(0.0)
    if code.rest:
        rest = rest_f(f, code.rest, form, argument(TABLE), wi, wo)
        if code.has_edges and code.lobe:
            f.note_line("The rest passes the interface in both ways.")
            ways = (("passed_i", wi), ("passed_o", wo))
            passed_i, passed_o = (passed(f, code.lobe, w, label) for label, w in ways)
            rest = passed_i * passed_o * rest
        value = value + rest
    f.returns(select(call("min", wi.z, wo.z) > 0.0, value, 0.0))

    made = Function("proposal", (*given, WI), "Proposal", "The proposal for wi.")
    seen = passed(made, code.terms.lobe, argument(WI)) if code.has_edges else 1.0
    made.returns(proposal.fill(made, code.terms, argument(WI), seen))
    sampling = _, density_of, _, draw = proposal.functions(len(alphas_of(code.terms.lobe)))
    note = "The density [1/sr] of `sample` at wo."
    pdf = Function("pdf", (*given, WI, WO), FLOAT, note, public=True)
    wi, wo = inside(pdf)
    pdf.returns(density_of(made(*own, wi), wi, wo))

    note = "A direction, about in proportion to f and its cosine; below the horizon density 0."
    sample = Function("sample", (*given, WI, U), SAMPLE.name, note, public=True)
    wi = tangent.inside(sample, argument(WI), "turned_i")
    # wi, or the normal where it is below the horizon.
    raised = sample.let("raised", select(wi.z > 0.0, wi, vector(0.0, 0.0, 1.0)))
    mixture = sample.let("mixture", made(*own, raised))
    direction = sample.let("drawn", draw(mixture, raised, argument(U)))
    result = sample.structure("result", SAMPLE.name)
    above = wi.z > 0.0
    seen = tangent.outside(sample, direction, "outside")
    density = density_of(mixture, raised, direction)
    sample.assign(member(result, SAMPLE.fields[0]), select(above, seen, vector(0.0, 0.0, 1.0)))
    sample.assign(member(result, SAMPLE.fields[1]), select(above, density, 0.0))
    sample.returns(result)
    called = [transmittance.function()] if code.has_edges else []
    return [*called, f, made, *sampling, pdf, sample]


def _conventions(model: Model) -> tuple[str, ...]:
    """How directions and values are meant in a file."""
    return CONVENTIONS if model.widths == 1 else (*CONVENTIONS, ANISOTROPIC)


def codes_program(model: Model, form: TextureForm, texels: Texels | None = None) -> Program:
    """The program of all materials; their codes are arguments, or read from a texture.

    form: of the textures of its language.
    """
    arch = model.arch
    structure = Structure(
        MATERIAL,
        (
            Variable("codes", COLOUR, arch.latent, "the lobe, and factors of the basis"),
            Variable("mean_lobe", FLOAT, arch.lobe, "that directions are drawn by"),
            Variable("terms", FLOAT, TERMS, "of the energies of the proposal's lobes"),
            *((STRETCH, *FIELDS) if arch.widths == 2 else ()),
        ),
        "A material. `prepare` makes it.",
    )
    prepare = _prepare(model, structure)

    material = Variable("material", MATERIAL)
    codes, lobe, energies, *others = (member(argument(material), x) for x in structure.fields)
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
    code = _Code(
        numbers[: arch.lobe],
        rest,
        terms,
        Tangent(*others[1:] or X_AXIS),
        texels is None or texels_have_edges(texels),
    )
    note: tuple[str, ...] = (
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
    functions = [prepare, *_functions(code, (material,), form)]
    if texels is None:
        return Program(note, structures, functions)
    note = (
        *note,
        "{fetch}(texels, uv) reads a material from the texture that belongs to this file: an array "
        f"of {texels.layers} layers, RGBA8 without gamma, whose first row is at v = 0. "
        f"{texels.filtering} Where the language separates samplers from textures, the sampler "
        "follows the texture.",
        *(() if code.has_edges else (NO_EDGES,)),
    )
    return Program(note, structures, [*functions, *fetch_functions(texels, prepare)])


def _prepare(model: Model, structure: Structure) -> Function:
    """The function that computes from codes what f and the proposal need."""
    arch = model.arch
    codes = Variable("codes", COLOUR, arch.latent)
    function = Function(
        "prepare",
        (codes,),
        MATERIAL,
        f"A material of its codes, {arch.latent} numbers for red, green and blue.",
        public=True,
    )
    numbers = [element(argument(codes), i) for i in range(arch.latent)]
    made = function.structure("made", MATERIAL)
    stored, lobe, terms, *others = (member(made, variable) for variable in structure.fields)
    for i, number in enumerate(numbers):
        function.assign(element(stored, i), number)
    function.note_line("Directions are drawn by the mean code of the channels.")
    mean = [
        function.let(f"mean{i}", (number.x + number.y + number.z) * (1.0 / 3.0))
        for i, number in enumerate(numbers)
    ]
    found = proposal.terms_of(model, mean)
    for target, values in (lobe, found.lobe), (terms, found.rest):
        for i, value in enumerate(values):
            function.assign(element(target, i), value)
    if found.stretch is not None:
        values = found.stretch, *X_AXIS
        for target, value in zip(others, values, strict=True):
            function.assign(target, value)
    function.returns(made)
    return function
