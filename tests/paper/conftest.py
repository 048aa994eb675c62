"""The paper's kinds of weights and data are registered, whichever test runs first."""

from urushi import paper

paper.register()
