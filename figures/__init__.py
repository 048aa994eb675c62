"""Figures and tables of the paper and of the docs, each made anew by one folder."""
