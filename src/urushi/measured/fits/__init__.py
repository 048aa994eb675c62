"""Analytic lobes fitted to a BRDF: what encoded measured materials are compared with."""

from urushi.measured.fits.fitting import LOSSES, MEASURES, candidates, fit
from urushi.measured.fits.lobes import GgxFit, Lobe

__all__ = ["LOSSES", "MEASURES", "GgxFit", "Lobe", "candidates", "fit"]
