"""Programs: a material with known codes, and all materials of given networks."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from urushi.errors import ParameterError
from urushi.export import networks, proposal
from urushi.export.expressions import (
    COLOUR,
    FLOAT,
    VOLUME,
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
from urushi.export.networks import FIELDS, X_AXIS, CodeTerms, FTable, Tangent, activation, dense
from urushi.export.proposal import LABELS, SAMPLE, WI, WO, U, argument
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

#: Languages that read textures.
TEXTURED = ("glsl", "wgsl", "hlsl", "slang")

#: The texture of a table of f.
TABLE = Variable("table", VOLUME)

#: The material of a file for all materials.
MATERIAL = "Material"


def material_text(
    language: str,
    model: Model,
    latents: np.ndarray,
    anchors: np.ndarray,
    prefix: str,
    rotation: float = 0.0,
    table: FTable | None = None,
) -> str:
    """The file of one material.

    Args:
        language: one of `LANGUAGES`.
        latents, anchors: (C, size), C being 1 or 3: codes by which f is evaluated and sampled.
        prefix: begins the names in the file.
        rotation: [degrees] by which the material's tangent is turned.
        table: by which f is evaluated; None: it is by the codes.
    """
    check(language, model, prefix)
    if table:
        check_textured(language)
    if len(latents) not in (1, 3):
        raise ParameterError(
            f"the material has {len(latents)} channels; only materials of one or three can be "
            "exported"
        )
    activations = [activation(FLOAT, model.arch.activation, "unit")]
    if len(latents) > 1 and not table:
        activations.append(activation(COLOUR, model.arch.activation, "units"))
    mean = anchors.mean(axis=0)
    has_lobe = table is None or table.beside_lobe
    lobe = latents[:, : model.arch.lobe] if has_lobe else np.zeros((1, model.arch.lobe))
    code = _Code(
        [colour(column) for column in lobe.T],
        networks.known_terms(model, latents),
        proposal.known_first(model, mean),
        [expression(float(mean[place])) for place in WIDTH_PLACES[model.widths]],
        Tangent.of(rotation),
    )
    reads = ", table" if table else ""
    note: tuple[str, ...] = (
        f"A material of Urushi as code, of the networks {model.fingerprint}.",
        f"Functions: {{f}}(wi, wo{reads}), {{pdf}}(wi, wo) and {{sample}}(wi, u).",
        *_conventions(model),
    )
    if table:
        depth, height, width = table.shape
        note = (
            *note,
            f"The table belongs to this file: a 3D texture of {width} x {height} x {depth} texels "
            "of the format RGBA16F. Its sampler has the wrap mode clamp to edge and linear "
            "filtering. Where the language separates samplers from textures, the sampler follows "
            "the texture.",
        )
    functions = _functions(model, code, (), activations[0], activations[-1], table)
    structures = (proposal.structure(model), SAMPLE)
    program = Program(note, structures, [*activations, *functions])
    return LANGUAGES[language](prefix).printed(program)


def codes_text(language: str, model: Model, prefix: str, texels: Texels | None = None) -> str:
    """The file of all materials of networks; their codes are arguments.

    texels: of a texture that the file also reads.
    """
    check(language, model, prefix)
    if texels:
        check_textured(language)
    return LANGUAGES[language](prefix).printed(codes_program(model, texels))


def template_text(language: str, model: Model) -> str:
    """The file of a material whose codes are still to be filled in, for writers without Python.

    It is the file of `codes_text` with a function `material` that prepares the codes. The number
    of a code and a channel is written as a name, `code_0_red` for the first. If the networks are
    anisotropic, `code_tangent_x` and `code_tangent_y` are the cosine and the sine of the rotation.
    """
    check(language, model, PREFIX)
    program = codes_program(model)
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
        "Functions: {material}(), once; then {f}(material, wi, wo), {pdf}(material, wi, wo) and "
        "{sample}(material, wi, u). {prepare}(codes) makes other materials.",
        *_conventions(model),
    )
    program = Program(note, program.structures, [*program.functions, made])
    return LANGUAGES[language](PREFIX).printed(program)


def check_textured(language: str) -> None:
    """Raise a ParameterError if files of a language read no textures."""
    if language not in TEXTURED:
        raise ParameterError(
            f"exported {LANGUAGES[language].title} code reads no textures; choose one of "
            + ", ".join(TEXTURED)
        )


def check(language: str, model: Model, prefix: str) -> None:
    """Raise a ParameterError if networks cannot be written in a language with a prefix."""
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

    lobe: Sequence[Expression]  # the numbers of its lobe
    terms: CodeTerms  # of the decoder
    first: Sequence[Expression]  # the code's part of the sampler's first layer
    alphas: Sequence[Expression]  # the widths of its lobe
    tangent: Tangent


def _functions(
    model: Model,
    code: _Code,
    given: tuple[Variable, ...],
    unit: Function,
    units: Function,
    table: FTable | None = None,
) -> list[Function]:
    """f, pdf and sample of a material, each after the functions that it calls.

    given: arguments before the directions. unit, units: the activations of floats and colours.
    table: by which f is evaluated; None: it is by the codes.
    """
    own, tangent = [argument(variable) for variable in given], code.tangent

    def inside(body: Function) -> tuple[Expression, Expression]:
        """wi and wo in the frame of the tangent."""
        wi = tangent.inside(body, argument(WI), "turned_i")
        return wi, tangent.inside(body, argument(WO), "turned_o")

    arguments = (*given, WI, WO, TABLE) if table else (*given, WI, WO)
    f = Function("f", arguments, COLOUR, "The BRDF [1/sr] without the cosine.", public=True)
    wi, wo = inside(f)
    value = networks.lobe_f(f, code.lobe, wi, wo)
    if table:
        rest = networks.tabulated(f, table, argument(TABLE), wi, wo)
    else:
        inputs = networks.features(f, wi, wo, model.widths)
        rest = networks.rest(f, model, code.terms, inputs, units)
    f.returns(select(call("min", wi.z, wo.z) > 0.0, value + rest, 0.0))

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


def codes_program(model: Model, texels: Texels | None = None) -> Program:
    """The program of all materials; their codes are arguments, or read from a texture."""
    arch = model.arch
    count, widths = 2 * arch.decoder[0], [f"alpha{label}" for label in LABELS[arch.widths]]
    structure = Structure(
        MATERIAL,
        (
            Variable("lobe", COLOUR, arch.lobe, "width, Fresnel factors and index of the lobe"),
            Variable("gain", COLOUR, note="added to the logarithm of the rest"),
            Variable("terms", COLOUR, count, "scales and offsets of the units"),
            Variable("first", FLOAT, arch.sampler[0], "of the sampler's first layer"),
            *(Variable(label, FLOAT, None, "width of the proposal's own lobe") for label in widths),
            *(FIELDS if arch.widths == 2 else ()),
        ),
        "A material: what the networks need of its codes. `prepare` makes it.",
    )
    unit = activation(FLOAT, arch.activation, "unit")
    units = activation(COLOUR, arch.activation, "units")
    prepare = _prepare(model, structure)

    material = Variable("material", MATERIAL)
    lobes, gain, terms, first, *others = (
        member(argument(material), variable) for variable in structure.fields
    )
    code = _Code(
        [element(lobes, i) for i in range(arch.lobe)],
        networks.split_terms(model, gain, [element(terms, i) for i in range(count)]),
        [element(first, i) for i in range(arch.sampler[0])],
        others[: arch.widths],
        Tangent(*others[arch.widths :] or X_AXIS),
    )
    note = (
        f"All materials of Urushi's networks {model.fingerprint} as code; the latent codes of a "
        "material are arguments.",
        f"Functions: {{prepare}}(codes), once for the {arch.latent} numbers of a material's codes, "
        "each for red, green and blue; then {f}(material, wi, wo), {pdf}(material, wi, wo) and "
        "{sample}(material, wi, u).",
        *_conventions(model),
        *((TURNED,) if arch.widths == 2 else ()),
    )
    structures = (structure, proposal.structure(model), SAMPLE)
    functions = [unit, units, prepare, *_functions(model, code, (material,), unit, units)]
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


def _prepare(model: Model, structure: Structure) -> Function:
    """The function that computes from codes the terms that f and the proposal need."""
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
    lobes, gain, terms, first, *others = (member(made, variable) for variable in structure.fields)
    for i in range(arch.lobe):
        function.assign(element(lobes, i), numbers[i])
    function.assign(gain, numbers[arch.lobe])
    function.note_line("Scales and offsets of the decoder's units.")
    weight, bias = networks.of_code(model)
    outputs = dense(function, "term", weight, numbers[arch.lobe + 1 :], bias.tolist())
    for i, output in enumerate(outputs):
        function.assign(element(terms, i), output)
    function.note_line("Directions are drawn by the mean code of the channels.")
    mean = [
        function.let(f"mean{i}", (number.x + number.y + number.z) * (1.0 / 3.0))
        for i, number in enumerate(numbers)
    ]
    inputs = [*networks.lobe_features(function, mean[: arch.lobe]), *mean[arch.lobe :]]
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
