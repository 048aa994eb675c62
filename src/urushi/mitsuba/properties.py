"""A plugin's properties, by their names, files and weights, and the values of its parameters.

The values are compared, and put back where an update is refused.
"""

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from typing import Any
from weakref import WeakSet, ref

import drjit as dr
import mitsuba as mi

from urushi.errors import ParameterError, choice
from urushi.nets import weights
from urushi.nets.weights import Model

#: Properties by which a plugin makes another: how its errors begin, and whether it is a part of a
#: slab.
INTERNAL = ("origin", "inner")


def describe(props: "mi.Properties") -> str:
    """The plugin's name, and its id if the user gave one; begins errors.

    Plugins that make others give them their own text as the property "origin".
    """
    if "origin" in props:
        return props["origin"]
    name = props.id()
    return props.plugin_name() + (f" '{name}'" if name and not name.startswith("__") else "")


def check_names(props: "mi.Properties", names: Collection[str], where: str) -> None:
    """Refuse a property that is none of `names` and no nested BSDF. Call this before reading any.

    Listing the objects resets Mitsuba's record of which properties were read.
    """
    objects = dict(props.objects(mark_queried=False))
    for name in props.keys():  # noqa: SIM118  (no mapping)
        if name not in (*names, *INTERNAL) and not isinstance(objects.get(name), mi.BSDF):
            raise ParameterError(f"{where}: there is no parameter '{name}'; {choice(name, names)}")


def ignore(props: "mi.Properties", *names: str) -> None:
    """Mark parameters of another plugin as used: Mitsuba refuses a scene with unused ones."""
    for name in names:
        if name in props:
            props.mark_queried(name)


def read_weights(props: "mi.Properties") -> Model | None:
    """The weights that the property `weights` names; None without it: shipped ones that fit."""
    name = props.get("weights", "")
    if not name:
        return None
    shipped = weights.DEFAULT, weights.ANISOTROPIC
    return weights.find(name if name in shipped else path_of(props, "weights"))


def path_of(props: "mi.Properties", name: str) -> str:
    """The file that a property names, found as Mitsuba does: relative to the scene file, then to
    the working folder."""
    path = props[name]
    if not isinstance(path, str):
        raise ParameterError(f"{describe(props)}: {name} is {path}; give the path of a file")
    return str(mi.file_resolver().resolve(path))


def switch_of(props: "mi.Properties", name: str, *, default: bool = False) -> bool:
    """A property that is true or false."""
    value = props.get(name, default)
    if not isinstance(value, bool):
        raise ParameterError(f"{describe(props)}: {name} is {value!r}; give true or false")
    return value


class ParameterSnapshot:
    """The values that `mi.traverse` lists below a plugin, as of its last accepted update."""

    def __init__(self) -> None:
        self._values: dict[str, Any] = {}
        self._plugin: Any = None  # a weak reference
        self._holders: WeakSet[ParameterSnapshot] = WeakSet()  # of plugins that contain this one
        self._restoring = False

    def keep(self, plugin: "mi.Object") -> None:
        """Remember the present values. Dr.Jit's arrays are copied when they are written."""
        self._values = {key: type(value)(value) for key, value in writable(plugin)}
        self._plugin = ref(plugin)
        for node in mi.traverse(plugin).hierarchy:
            inner = getattr(node, "_snapshot", self)
            if inner is not self:
                inner._holders.add(self)

    @contextmanager
    def restored_on_error(self, plugin: "mi.Object") -> Iterator[None]:
        """Run an update; where it is refused, put the kept values back and update again.

        So it is in the plugins that contain this one: one update may change them, too.
        """
        held = [self, *self._holders]
        restoring = any(x._restoring for x in held)
        try:
            yield
        except ParameterError:
            if not restoring:
                for snapshot in held:
                    if not snapshot._holders:
                        snapshot._restore()
            raise
        self.keep(plugin)

    def _restore(self) -> None:
        plugin = self._plugin and self._plugin()
        if plugin is None:
            return
        self._restoring = True
        try:
            parameters = mi.traverse(plugin)
            parameters.update({k: v for k, v in self._values.items() if k in parameters})
        finally:
            self._restoring = False


def has_gradients(plugin: "mi.Object") -> bool:
    """Whether a parameter below a plugin carries a gradient, also where gradients are suspended."""
    return any(is_attached(value) for _, value in writable(plugin))


def is_attached(value: Any) -> bool:
    """Whether a value carries a gradient, also where gradients are suspended."""
    if dr.is_tensor_v(value):
        return bool(value.array.index_ad)
    if not dr.is_array_v(value) or not dr.is_diff_v(value):
        return False
    return bool(value.index_ad) if dr.depth_v(value) == 1 else any(map(is_attached, value))


def writable(plugin: "mi.Object") -> list[tuple[str, Any]]:
    """Names and values of the parameters below a plugin that are not read-only."""
    parameters, read_only = mi.traverse(plugin), mi.ParamFlags.ReadOnly
    return [(key, value) for key, value in parameters if not parameters.flags(key) & read_only]
