"""Fixtures for the tests of stores."""

import hashlib

import pytest


@pytest.fixture(scope="session")
def fingerprints():
    """A function of a store's path: the hash of each of its files, by name."""

    def of(path):
        return {
            str(file.relative_to(path)): hashlib.sha256(file.read_bytes()).hexdigest()
            for file in path.rglob("*")
            if file.is_file()
        }

    return of
