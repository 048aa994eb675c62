"""The paper's kinds of weights and data are registered before any test of this folder."""

from urushi import fan2022

fan2022.register()
