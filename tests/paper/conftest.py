"""The paper's kinds of weights and data are registered before any test of this folder."""

from urushi import paper

paper.register()
