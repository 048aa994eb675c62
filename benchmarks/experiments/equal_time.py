"""What codes are worth at equal time, in scenes under three kinds of light.

Passes of the walk, of codes and of Mitsuba's `principled` alternate in one process. Ratios of mean
squared errors at equal CPU time are for the time in which the walk takes `COUNT` samples per pixel.
"""

from benchmarks.experiment import NETWORKS, Experiment, Found, Options
from benchmarks.pictures import Method, at_equal_time
from benchmarks.scenes import LIGHTS, PRINCIPLED, WALK, View
from benchmarks.showing import table

from urushi.nets.weights import DEFAULT

SCENES = ("still-life", "globe", "teapot")
LABELS = {"own": "studio", "point": "point light", "sky": "sun and sky"}
#: Samples per pixel of the walk that give the time of the comparison; samples of the reference, and
#: CPU seconds of each method.
COUNT, SAMPLES, SECONDS = 64, 512, 6.0
#: Longest path: direct light. Caustics of small lights are single bright samples, which path
#: tracing hardly finds, and which would decide the means.
DEPTH = 2


def cases(_: Options) -> dict[str, View]:
    return {
        f"{scene}, {light}": View(scene, light, depth=DEPTH) for scene in SCENES for light in LIGHTS
    }


def measure(view: View, options: Options) -> Found:
    """Costs and variances of codes over the walk's, and what both ratios are worth.

    `time` and `variance` of a sample over the walk's, `bias` over the walk's variance, and the
    walk's mean squared error at equal time over that of `networks` and of an `exact` BSDF without
    noise that costs what `principled` does.
    """
    networks = options.weights or DEFAULT
    names, samples = (WALK, PRINCIPLED, networks), options.count(SAMPLES, 32)
    methods, reference = at_equal_time(view, names, samples, options.share * SECONDS)
    walk, cheap, ours = (methods[name] for name in names)
    return {
        "time": ours.second / walk.second,
        "variance": ours.variance / walk.variance,
        "bias": ours.bias(reference) / walk.variance,
        "networks": gain(walk, ours, ours.bias(reference)),
        "exact": gain(walk, ours, 0.0, cheap.second),
    }


def gain(walk: Method, method: Method, bias: float, second: float | None = None) -> float:
    """The walk's mean squared error over that of a method at the walk's time.

    second: CPU time of a sample; default: the method's.
    """
    spread = method.variance * (second or method.second) / walk.second
    return walk.variance / (spread + COUNT * bias)


def tables(found: Found) -> list[str]:
    """A row for each scene and light."""
    columns = ("time", "variance", "networks", "exact")
    rows = []
    for name, case in found.items():
        scene, light = name.split(", ")
        rows.append([scene, LABELS[light], *(f"{case[key]:.2g}" for key in columns)])
    return [table(["scene", "light", *columns], rows)]


EXPERIMENT = Experiment(cases, tables, measure, models=NETWORKS, minutes=7)
