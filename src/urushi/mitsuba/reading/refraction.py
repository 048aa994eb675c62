"""Indices of refraction in a plugin's properties: numbers, or names of materials."""

import mitsuba as mi

from urushi.errors import ParameterError

#: Indices of refraction by name, the same names and values as in Mitsuba's own plugins; at about
#: 589 nm, most from Hecht, Optics, fourth edition.
IOR = {
    "vacuum": 1.0,
    "helium": 1.000036,
    "hydrogen": 1.000132,
    "air": 1.000277,
    "carbon dioxide": 1.00045,
    "water": 1.3330,
    "acetone": 1.36,
    "ethanol": 1.361,
    "carbon tetrachloride": 1.461,
    "glycerol": 1.4729,
    "benzene": 1.501,
    "silicone oil": 1.52045,
    "bromine": 1.661,
    "water ice": 1.31,
    "fused quartz": 1.458,
    "pyrex": 1.470,
    "acrylic glass": 1.49,
    "polypropylene": 1.49,
    "bk7": 1.5046,
    "sodium chloride": 1.544,
    "amber": 1.55,
    "pet": 1.5750,
    "diamond": 2.419,
}


def index_of_refraction(props: "mi.Properties", name: str, default: str, where: str) -> float:
    """The index of refraction that a property gives as a number or as a material's name.

    Raises:
        ParameterError: neither a number nor a known name.
    """
    value = props.get(name, default)
    if isinstance(value, int | float) and not isinstance(value, bool):
        return float(value)
    if isinstance(value, str) and value.lower() in IOR:
        return IOR[value.lower()]
    if not isinstance(value, str):
        what = "texture" if isinstance(value, mi.Texture) else type(value).__name__
        raise ParameterError(f"{where} is a {what}; give a number or the name of a material")
    raise ParameterError(
        f"{where} is {value!r}; give a number or one of the materials " + ", ".join(IOR)
    )
