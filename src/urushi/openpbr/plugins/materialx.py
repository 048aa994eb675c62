"""The plugin `materialx`: a material of a MaterialX document."""

import mitsuba as mi

from urushi.errors import ParameterError
from urushi.mitsuba.plugins.base import resolve
from urushi.mitsuba.reading.parameters import describe
from urushi.openpbr.documents import RESOLUTION, load_materialx


def define():
    """Make the plugin's constructor, which is the same in every variant."""

    def materialx(props):
        """A material of a MaterialX document (``materialx``).

        ============== ===================== ====================================================
        filename       string                The document (``.mtlx``), relative to the scene file.
                                             (Required)
        material       string                Name of the material. (Default: the document's only
                                             one)
        bake           integer               Rows and columns of textures that are computed from
                                             patterns. (Default: 1024)
        uv_plane       boolean               Take patterns in space on the plane (u, v, 0) instead
                                             of refusing them. (Default: false)
        ============== ===================== ====================================================

        All other properties go to ``openpbr``, of which this is an instance: ``reference``,
        ``unsupported``, and parameters of OpenPBR, which replace those of the document.

        .. tabs::
            .. code-tab:: xml

                <bsdf type="materialx">
                    <string name="filename" value="paints.mtlx"/>
                    <string name="material" value="Red"/>
                </bsdf>

            .. code-tab:: python

                'type': 'materialx',
                'filename': 'paints.mtlx',
                'material': 'Red'
        """
        where = describe(props)
        if "filename" not in props:
            raise ParameterError(f"{where} has no filename; give a MaterialX document")
        path, name = resolve(props["filename"]), props.get("material", None)
        resolution, plane = int(props.get("bake", RESOLUTION)), bool(props.get("uv_plane", False))
        bsdf = load_materialx(path, name, resolution, plane)
        for key in list(props.keys()):
            if key not in ("filename", "material", "bake", "uv_plane"):
                bsdf[key] = props[key]
        if props.id():
            bsdf["id"] = props.id()
        return mi.load_dict(bsdf)

    return materialx
