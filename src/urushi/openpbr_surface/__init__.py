"""OpenPBR Surface 1.1.1 and MaterialX: an extension that the rest of Urushi does not import.

`plugins` has the Mitsuba plugins, `materialx` reads and writes documents. The argument `where` of a
function begins its errors. The specification is by Andersson et al., OpenPBR Surface, Academy
Software Foundation.
"""
