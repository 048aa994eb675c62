"""Materials as source code: one description of f, one printer for each language.

`expressions` and `statements` are the form in which a computation is described. `lobe`, `rest` and
`proposal` describe it, `program` joins them to a file, and `printer` with `languages` prints it.
"""
