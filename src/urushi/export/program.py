"""Programs: a material with known codes, and all materials of given networks."""

import numpy as np

from urushi.errors import ParameterError
from urushi.export import decoder, lobe, proposal
from urushi.export.dense import activation, dense
from urushi.export.expressions import (
    COLOUR,
    FLOAT,
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
from urushi.export.proposal import SAMPLE, WI, WO, Sampling, U, argument
from urushi.export.statements import (
    Function,
    Lookup,
    Program,
    Structure,
    Variable,
    element,
    member,
)
from urushi.export.texels import Texels, texel_function
from urushi.nets.networks import UrushiNetworks
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

#: Beginning of the names in templates.
PREFIX = "urushi"

#: Languages that read textures.
TEXTURED = ("glsl", "wgsl", "hlsl", "slang")

#: The material of a file for all materials.
MATERIAL = "Material"


def material_text(
    language: str,
    model: Model,
    latents: np.ndarray,
    anchors: np.ndarray,
    prefix: str,
) -> str:
    """The file of one material.

    Args:
        language: one of `LANGUAGES`.
        latents, anchors: (C, size), C being 1 or 3: codes by which f is evaluated and sampled.
        prefix: begins the names in the file.

    Raises:
        ParameterError: an unknown language or a prefix that is no name, a material of another
            number of channels, or networks without analytic lobes.
    """
    check(language, model, prefix)
    if len(latents) not in (1, 3):
        raise ParameterError(
            f"the material has {len(latents)} channels; only one or three can become a shader"
        )
    return LANGUAGES[language](prefix).printed(material_program(model, latents, anchors))


def codes_text(language: str, model: Model, prefix: str, texels: Texels | None = None) -> str:
    """The file of all materials of networks; their codes are arguments.

    texels: of a texture that the file also reads.

    Raises:
        ParameterError: an unknown language or a prefix that is no name, networks without analytic
            lobes, or a texture in a language without array textures.
    """
    check(language, model, prefix)
    if texels and language not in TEXTURED:
        raise ParameterError(
            f"{LANGUAGES[language].title} has no array textures; choose one of "
            + ", ".join(TEXTURED)
        )
    return LANGUAGES[language](prefix).printed(codes_program(model, texels))


def template_text(language: str, model: Model) -> str:
    """The file of a material whose codes are still to be filled in, for writers without Python.

    It is the file of `codes_text` with a function `material` that prepares the codes. The number
    of a code and a channel is written as a name, `code_0_red` for the first.

    Raises:
        ParameterError: as `codes_text`.
    """
    check(language, model, PREFIX)
    return LANGUAGES[language](PREFIX).printed(template_program(model))


def check(language: str, model: Model, prefix: str) -> None:
    """Raise a ParameterError if networks cannot be written in a language with a prefix."""
    if language not in LANGUAGES:
        raise ParameterError(
            f"there is no language '{language}'; choose one of {', '.join(LANGUAGES)}"
        )
    if not (prefix.isascii() and prefix.isidentifier()) or "__" in prefix or prefix[0] == "_":
        raise ParameterError(
            f"'{prefix}' cannot begin the names of functions; give letters, digits and single "
            "underscores, a letter first"
        )
    if model.widths == 2:
        raise ParameterError(
            f"the weights {model.fingerprint} are for anisotropic materials, which cannot be "
            "written as source code; render the material in Mitsuba, or give it one alpha"
        )
    if not isinstance(model.networks, UrushiNetworks):
        raise ParameterError(
            f"the networks {model.fingerprint} are of another system and cannot become a shader; "
            "encode the material with Urushi's networks"
        )


def material_program(model: Model, latents: np.ndarray, anchors: np.ndarray) -> Program:
    """The program of a material of known codes."""
    channels = len(latents)
    unit = activation(FLOAT, model.arch.activation, "unit")
    functions = [unit]
    numbers = [colour(column) for column in latents[:, : model.arch.lobe].T]

    f = Function("f", (WI, WO), COLOUR, "The BRDF [1/sr] without the cosine.", public=True)
    wi, wo = argument(WI), argument(WO)
    value = lobe.f(f, numbers, wi, wo)
    inputs = decoder.features(f, wi, wo)
    activated = activation(COLOUR, model.arch.activation, "units") if channels > 1 else unit
    rest = decoder.rest(f, model, decoder.known_terms(model, latents), inputs, activated)
    if activated is not unit:
        functions.append(activated)
    f.returns(_above(wi, wo, value + rest))

    cos_i = Variable("cosine_i", FLOAT)
    made = Function("proposal", (cos_i,), "Proposal", "The proposal for a cosine of wi.")
    mean = anchors.mean(axis=0)
    first = proposal.known_first(model, mean)
    made.returns(
        proposal.fill(made, model, first, expression(float(mean[0])), argument(cos_i), unit)
    )
    sampling = proposal.functions(model)
    pdf = Function("pdf", (WI, WO), FLOAT, "The density [1/sr] of `sample` at wo.", public=True)
    pdf.returns(sampling.density(made(wi.z), wi, wo))
    sample = Function("sample", (WI, U), SAMPLE.name, SAMPLE_NOTE, public=True)
    raised = _raised(sample, wi)
    _sampled(sample, made(raised.z), sampling, wi, raised)
    note = (
        f"A material of Urushi as code, of the networks {model.fingerprint}.",
        "Functions: {f}(wi, wo), {pdf}(wi, wo) and {sample}(wi, u).",
        *CONVENTIONS,
    )
    structures = (proposal.structure(model), SAMPLE)
    return Program(note, structures, [*functions, f, made, *sampling.all, pdf, sample])


SAMPLE_NOTE = "A direction, about in proportion to f and its cosine; below the horizon density 0."


def material_structure(model: Model) -> Structure:
    """What `prepare` makes of codes."""
    arch = model.arch
    terms = 2 * arch.decoder[0]
    return Structure(
        MATERIAL,
        (
            Variable("lobe", COLOUR, arch.lobe, "width, Fresnel factors and index of the lobe"),
            Variable("gain", COLOUR, note="added to the logarithm of the rest"),
            Variable("terms", COLOUR, terms, "scales and offsets of the units"),
            Variable("first", FLOAT, arch.sampler[0], "of the sampler's first layer"),
            Variable("alpha", FLOAT, note="width of the proposal's own lobe"),
        ),
        "A material: what the networks need of its codes. `prepare` makes it.",
    )


def codes_program(model: Model, texels: Texels | None = None) -> Program:
    """The program of all materials; their codes are arguments, or read from a texture."""
    arch = model.arch
    structure = material_structure(model)
    unit = activation(FLOAT, arch.activation, "unit")
    units = activation(COLOUR, arch.activation, "units")
    prepare = _prepare(model, structure)

    material = Variable("material", MATERIAL)
    lobes, gain, terms, first, alpha = (
        member(argument(material), variable) for variable in structure.fields
    )
    f = Function(
        "f", (material, WI, WO), COLOUR, "The BRDF [1/sr] without the cosine.", public=True
    )
    wi, wo = argument(WI), argument(WO)
    value = lobe.f(f, [element(lobes, i) for i in range(arch.lobe)], wi, wo)
    inputs = decoder.features(f, wi, wo)
    count = structure.fields[2].count or 0
    parts = decoder.split_terms(model, gain, [element(terms, i) for i in range(count)])
    rest = decoder.rest(f, model, parts, inputs, units)
    f.returns(_above(wi, wo, value + rest))

    cos_i = Variable("cosine_i", FLOAT)
    made = Function("proposal", (material, cos_i), "Proposal", "The proposal for a cosine of wi.")
    firsts = [element(first, i) for i in range(arch.sampler[0])]
    made.returns(proposal.fill(made, model, firsts, alpha, argument(cos_i), unit))
    sampling = proposal.functions(model)
    pdf = Function(
        "pdf", (material, WI, WO), FLOAT, "The density [1/sr] of `sample` at wo.", public=True
    )
    pdf.returns(sampling.density(made(argument(material), wi.z), wi, wo))
    sample = Function("sample", (material, WI, U), SAMPLE.name, SAMPLE_NOTE, public=True)
    raised = _raised(sample, wi)
    _sampled(sample, made(argument(material), raised.z), sampling, wi, raised)
    note: tuple[str, ...] = (
        f"All materials of Urushi's networks {model.fingerprint} as code; the latent codes of a "
        "material are arguments.",
        f"Functions: {{prepare}}(codes), once for the {arch.latent} numbers of a material's codes, "
        "each for red, green and blue; then {f}(material, wi, wo), {pdf}(material, wi, wo) and "
        "{sample}(material, wi, u).",
        *CONVENTIONS,
    )
    structures = (structure, proposal.structure(model), SAMPLE)
    functions = [unit, units, prepare, f, made, *sampling.all, pdf, sample]
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
    lookup = Lookup(texel, texels.layers, texels.to_texture)
    return Program(note, structures, [*functions, texel], lookup)


def template_program(model: Model) -> Program:
    """The program of `codes_program`, and a function that gives the material of named numbers."""
    program = codes_program(model)
    prepare = next(function for function in program.functions if function.name == "prepare")
    made = Function("material", (), MATERIAL, "This material; make it once.", public=True)
    codes = made.array("codes", COLOUR, model.arch.latent)
    for i in range(model.arch.latent):
        numbers = (name(f"code_{i}_{channel}", FLOAT) for channel in ("red", "green", "blue"))
        made.assign(element(codes, i), colour_of(*numbers))
    made.returns(prepare(codes))
    note = (
        f"A material of Urushi as code, of the networks {model.fingerprint}.",
        "Functions: {material}(), once; then {f}(material, wi, wo), {pdf}(material, wi, wo) and "
        "{sample}(material, wi, u). {prepare}(codes) makes other materials.",
        *CONVENTIONS,
    )
    return Program(note, program.structures, [*program.functions, made])


def _prepare(model: Model, structure: Structure) -> Function:
    """The function that turns codes into what f and the proposal need."""
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
    lobes, gain, terms, first, alpha = (member(made, variable) for variable in structure.fields)
    for i in range(arch.lobe):
        function.assign(element(lobes, i), numbers[i])
    function.assign(gain, numbers[arch.lobe])
    function.note_line("Scales and offsets of the decoder's units.")
    weight, bias = decoder.of_code(model)
    outputs = dense(
        function, "term", weight, numbers[arch.lobe + 1 :], [float(value) for value in bias]
    )
    for i, output in enumerate(outputs):
        function.assign(element(terms, i), output)
    function.note_line("Directions are drawn by the mean code of the channels.")
    mean = [
        function.let(f"mean{i}", (number.x + number.y + number.z) * (1.0 / 3.0))
        for i, number in enumerate(numbers)
    ]
    inputs = [*lobe.features(function, mean[: arch.lobe]), *mean[arch.lobe :]]
    weight, bias = model.params["sampler.0.weight"][:-2], model.params["sampler.0.bias"]
    outputs = dense(function, "first", weight, inputs, [float(value) for value in bias])
    for i, output in enumerate(outputs):
        function.assign(element(first, i), output)
    function.assign(alpha, mean[0])
    function.returns(made)
    return function


def _above(wi: Expression, wo: Expression, value: Expression) -> Expression:
    return select(call("min", wi.z, wo.z) > 0.0, value, 0.0)


def _raised(body: Function, wi: Expression) -> Expression:
    """wi, or the normal where it is below the horizon."""
    return body.let("raised", select(wi.z > 0.0, wi, vector(0.0, 0.0, 1.0)))


def _sampled(
    body: Function,
    mixture: Expression,
    sampling: Sampling,
    wi: Expression,
    raised: Expression,
) -> None:
    """Return a direction of a proposal and its density."""
    mixture = body.let("mixture", mixture)
    direction = body.let("drawn", sampling.draw(mixture, raised, argument(U)))
    result = body.structure("result", SAMPLE.name)
    above = wi.z > 0.0
    body.assign(member(result, SAMPLE.fields[0]), select(above, direction, vector(0.0, 0.0, 1.0)))
    body.assign(
        member(result, SAMPLE.fields[1]),
        select(above, sampling.density(mixture, raised, direction), 0.0),
    )
    body.returns(result)
