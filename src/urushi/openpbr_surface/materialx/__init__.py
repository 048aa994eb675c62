"""MaterialX documents: reading them as parameters of OpenPBR, and writing them.

Reading needs no Mitsuba. Pictures are decoded by a function that the caller gives. The package
`materialx` is used for its libraries of nodes and for upgrading old documents only; a document is
parsed and checked before that package sees it.
"""
