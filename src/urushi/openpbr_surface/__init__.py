"""OpenPBR Surface 1.1.1: its parameters, and what they mean as layers.

Pure NumPy. The specification is by Andersson et al., OpenPBR Surface, Academy Software Foundation.
"""
