"""Descriptions of layered materials and the simulators that they are checked against."""

from urushi.walk.simulate import simulate, walk_pairs
from urushi.walk.stack import (
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
from urushi.walk.table import StackTable

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
