"""Descriptions of layered materials and the simulators that they are checked against."""

from urushi.walk.bottoms.conductor import Conductor, conductor
from urushi.walk.bottoms.dielectric import Dielectric, dielectric
from urushi.walk.bottoms.diffuse import Diffuse, diffuse
from urushi.walk.simulate import simulate, walk_pairs
from urushi.walk.stack import Coat, Stack, coat, slab
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
    "slab",
    "walk_pairs",
]
