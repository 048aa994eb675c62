"""Programs: a material with known codes, and all materials of given networks."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from urushi.errors import ParameterError
from urushi.export import proposal, rest
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
from urushi.export.lobe import FIELDS, X_AXIS, Tangent, lobe_f, lobe_features
from urushi.export.proposal import LABELS, SAMPLE, WI, WO, U, activation, argument, dense
from urushi.export.rest import RestTable, TextureForm, basis_of
from urushi.export.statements import (
    Function,
    Program,
    Structure,
    Texels,
    Variable,
    element,
    member,
    texel_function,
)
from urushi.nets.lobe import WIDTH_PLACES
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

#: Further conventions of anisotropic networks, and how a file for all materials turns one.
ANISOTROPIC = (
    "The x axis of the frame is the tangent of the shape. f is the same for the mirror images of "
    "wi and wo at the plane of the normal and the material's tangent, and at the plane across."
)
TURNED = (
    "A material's tangent is the x axis. To turn it, set tangent_x and tangent_y of the material "
    "to the cosine and the sine of the angle."
)

#: Beginning of the names in templates.
PREFIX = "urushi"

#: Languages that read codes from textures.
TEXTURED = ("glsl", "wgsl", "hlsl", "slang")

#: The texture of ln f or of the basis.
TABLE = Variable("table", TEXTURE)

#: How its texture is used.
FILTERING = (
    "Its sampler filters linearly. Where the language separates samplers from textures, the "
    "sampler follows the texture."
)

#: The material of a file for all materials.
MATERIAL = "Material"


def material_text(
    language: str,
    model: Model,
    latents: np.ndarray,
    prefix: str,
    rotation: float = 0.0,
    table: RestTable | None = None,
) -> str:
    """The file of one material.

    Args:
        language: one of `LANGUAGES`.
        latents: (C, size), C being 1 or 3: codes, by whose lobes f is evaluated and which are
            sampled.
        prefix: begins the names in the file.
        rotation: [degrees] by which the material's tangent is turned.
        table: of ln f, in the texture `rest.own_texture`; None: f is the lobe.
    """
    check(language, prefix)
    if len(latents) not in (1, 3):
        raise ParameterError(
            f"the material has {len(latents)} channels; only materials of one or three can be "
            "exported"
        )
    mean, has_lobe = latents.mean(axis=0), table is None or table.beside_lobe
    code = _Code(
        [colour(column) for column in latents[:, : model.arch.lobe].T] if has_lobe else (),
        None,
        proposal.known_first(model, mean),
        [expression(float(mean[place])) for place in WIDTH_PLACES[model.widths]],
        Tangent.of(rotation),
    )
    printer = LANGUAGES[language](prefix)
    note: tuple[str, ...] = (
        f"A material of Urushi as code, of the networks {model.fingerprint}.",
        f"Functions: {{f}}(wi, wo{', table' if table else ''}), {{pdf}}(wi, wo) and "
        "{sample}(wi, u).",
        *_conventions(model),
    )
    if table:
        note = *note, f"The table is a texture of this material: {_size(table, printer.form)}"
    unit = activation(model.arch.activation)
    functions = [unit, *_functions(model, code, (), unit, table, printer.form)]
    return printer.printed(Program(note, (proposal.structure(model), SAMPLE), functions))


def _size(table: RestTable, form: TextureForm) -> str:
    """What a texture is, in sentences."""
    size = " x ".join(map(str, reversed(rest.texture_shape(table, form))))
    return f"{size} texels of half floats, {form.numbers} each. {FILTERING}"


def codes_text(language: str, model: Model, prefix: str, texels: Texels | None = None) -> str:
    """The file of all materials of networks; their codes are arguments.

    It reads the texture `rest.basis_texture`.

    texels: of a texture of codes that the file also reads.
    """
    check(language, prefix)
    if texels and language not in TEXTURED:
        raise ParameterError(
            f"exported {LANGUAGES[language].title} code reads no latent textures; choose one of "
            + ", ".join(TEXTURED)
        )
    printer = LANGUAGES[language](prefix)
    return printer.printed(codes_program(model, printer.form, texels))


def template_text(language: str, model: Model) -> str:
    """The file of a material whose codes are still to be filled in, for writers without Python.

    It is the file of `codes_text` with a function `material` that prepares the codes. The number
    of a code and a channel is written as a name, `code_0_red` for the first. If the networks are
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
        f"A material of Urushi as code, of the networks {model.fingerprint}.",
        "Functions: {material}(), once; then {f}(material, wi, wo, table), {pdf}(material, wi, wo) "
        "and {sample}(material, wi, u). {prepare}(codes) makes other materials.",
        *_conventions(model),
        _basis_note(model, printer.form),
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
    """The terms of a material's codes that its functions use."""

    lobe: Sequence[Expression]  # the numbers of its lobe; empty without one
    rest: Sequence[Expression] | None  # the numbers of the basis; None: the table is its own
    first: Sequence[Expression]  # the code's part of the sampler's first layer
    alphas: Sequence[Expression]  # the widths of its lobe
    tangent: Tangent


def _functions(
    model: Model,
    code: _Code,
    given: tuple[Variable, ...],
    unit: Function,
    table: RestTable | None,
    form: TextureForm,
) -> list[Function]:
    """f, pdf and sample of a material, each after the functions that it calls.

    given: arguments before the directions. unit: the sampler's activation. table: of ln f or of the
    basis; None: f is the lobe.
    """
    own, tangent = [argument(variable) for variable in given], code.tangent

    def inside(body: Function) -> tuple[Expression, Expression]:
        """wi and wo in the frame of the tangent."""
        wi = tangent.inside(body, argument(WI), "turned_i")
        return wi, tangent.inside(body, argument(WO), "turned_o")

    arguments = (*given, WI, WO, TABLE) if table else (*given, WI, WO)
    f = Function("f", arguments, COLOUR, "The BRDF [1/sr] without the cosine.", public=True)
    wi, wo = inside(f)
    value = lobe_f(f, code.lobe, wi, wo) if code.lobe else expression(0.0)
    if table:
        value = value + rest.rest_f(f, table, form, argument(TABLE), code.rest, wi, wo)
    f.returns(select(call("min", wi.z, wo.z) > 0.0, value, 0.0))

    made = Function("proposal", (*given, WI), "Proposal", "The proposal for wi.")
    made.returns(proposal.fill(made, model, code.first, code.alphas, argument(WI), unit))
    sampling = _, density_of, _, draw = proposal.functions(model)
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
    return [f, made, *sampling, pdf, sample]


def _conventions(model: Model) -> tuple[str, ...]:
    """How directions and values are meant in a file."""
    return CONVENTIONS if model.widths == 1 else (*CONVENTIONS, ANISOTROPIC)


def codes_program(model: Model, form: TextureForm, texels: Texels | None = None) -> Program:
    """The program of all materials; their codes are arguments, or read from a texture.

    form: of the textures of its language.
    """
    arch = model.arch
    widths = [f"alpha{label}" for label in LABELS[arch.widths]]
    structure = Structure(
        MATERIAL,
        (
            Variable("codes", COLOUR, arch.latent, "the lobe, and factors of the basis"),
            Variable("first", FLOAT, arch.sampler[0], "of the sampler's first layer"),
            *(Variable(label, FLOAT, None, "width of the proposal's own lobe") for label in widths),
            *(FIELDS if arch.widths == 2 else ()),
        ),
        "A material. `prepare` makes it.",
    )
    unit = activation(arch.activation)
    prepare = _prepare(model, structure)

    material = Variable("material", MATERIAL)
    codes, first, *others = (member(argument(material), field) for field in structure.fields)
    numbers = [element(codes, i) for i in range(arch.latent)]
    code = _Code(
        numbers[: arch.lobe],
        numbers[arch.lobe :],
        [element(first, i) for i in range(arch.sampler[0])],
        others[: arch.widths],
        Tangent(*others[arch.widths :] or X_AXIS),
    )
    note: tuple[str, ...] = (
        f"All materials of Urushi's networks {model.fingerprint} as code; the latent codes of a "
        "material are arguments.",
        f"Functions: {{prepare}}(codes), once for the {arch.latent} numbers of a material's codes, "
        "each for red, green and blue; then {f}(material, wi, wo, table), {pdf}(material, wi, wo) "
        "and {sample}(material, wi, u).",
        *_conventions(model),
        *((TURNED,) if arch.widths == 2 else ()),
        _basis_note(model, form),
    )
    structures = (structure, proposal.structure(model), SAMPLE)
    table = _basis_table(model)
    functions = [unit, prepare, *_functions(model, code, (material,), unit, table, form)]
    if texels is None:
        return Program(note, structures, functions)
    texel = texel_function(texels, prepare)
    note = (
        *note,
        "{fetch}(texels, uv) reads a material from the texture that belongs to this file: an array "
        f"of {texels.layers} layers, RGBA8 without gamma, whose first row is at v = 0. "
        f"{texels.filtering} Where the language separates samplers from textures, the sampler "
        "follows the texture. {fetch_level} takes the level as a last argument.",
    )
    return Program(note, structures, [*functions, texel], texels)


def _basis_note(model: Model, form: TextureForm) -> str:
    size = _size(_basis_table(model), form)
    return f"The table is the texture of the basis, for all materials: {size}"


def _basis_table(model: Model) -> RestTable:
    basis = basis_of(model)
    return RestTable(basis.widths, basis.count)


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
    stored, first, *others = (member(made, variable) for variable in structure.fields)
    for i, number in enumerate(numbers):
        function.assign(element(stored, i), number)
    function.note_line("Directions are drawn by the mean code of the channels.")
    mean = [
        function.let(f"mean{i}", (number.x + number.y + number.z) * (1.0 / 3.0))
        for i, number in enumerate(numbers)
    ]
    inputs = [*lobe_features(function, mean[: arch.lobe]), *mean[arch.lobe :]]
    weight, bias = model.params["sampler.0.weight"][: len(inputs)], model.params["sampler.0.bias"]
    outputs = dense(function, "first", weight, inputs, bias.tolist())
    for i, output in enumerate(outputs):
        function.assign(element(first, i), output)
    places = WIDTH_PLACES[arch.widths]
    for alpha, place in zip(others[: arch.widths], places, strict=True):
        function.assign(alpha, mean[place])
    for component, value in zip(others[arch.widths :], X_AXIS, strict=False):
        function.assign(component, value)
    function.returns(made)
    return function
