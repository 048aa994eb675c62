"""Affinity masks and containers' limits bound the number of cores."""

import os

import pytest

from urushi import platform


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("max 100000\n", 8),
        ("200000 100000\n", 2),
        ("150000 100000\n", 2),  # one and a half are worth two threads
        ("5000 100000\n", 1),
        ("9900000 100000\n", 8),
        ("", 8),
        (None, 8),
    ],
)
def test_a_containers_limit(text, expected, tmp_path, monkeypatch):
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(8)), raising=False)
    monkeypatch.setattr(platform, "CGROUP_CPU_MAX", tmp_path / "cpu.max")
    if text is not None:
        platform.CGROUP_CPU_MAX.write_text(text)
    assert platform.available_cores() == expected


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="this system has no masks")
def test_an_affinity_mask():
    before = os.sched_getaffinity(0)
    try:
        os.sched_setaffinity(0, {min(before)})
        assert platform.available_cores() == 1
    finally:
        os.sched_setaffinity(0, before)
    assert 1 <= platform.available_cores() <= len(before)
