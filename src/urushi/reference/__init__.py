"""Descriptions of layered materials and the simulators that they are checked against."""

from urushi.reference.simulate import simulate, walk_pairs
from urushi.reference.stack import (
    Coat,
    Conductor,
    Dielectric,
    Diffuse,
    Stack,
    coat,
    conductor,
    dielectric,
    diffuse,
)
from urushi.reference.table import StackTable

__all__ = [
    "Coat",
    "Conductor",
    "Dielectric",
    "Diffuse",
    "Stack",
    "StackTable",
    "coat",
    "conductor",
    "dielectric",
    "diffuse",
    "simulate",
    "walk_pairs",
]
