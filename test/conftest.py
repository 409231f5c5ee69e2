"""What a robot has is what rosdep gives it: tests that need more are left out there, and say so."""

import importlib.util
from pathlib import Path

import pytest

NEEDS = {
    'rosbags': ('support.recorded', 'colortrack_ros.bags', 'colortrack_ros.replay', 'rosbags'),
    'motmetrics': ('support.scoring', 'motmetrics'),
}
"""Modules that no rosdep key gives, and what cannot be imported without them."""

MISSING = [name for name in NEEDS if importlib.util.find_spec(name) is None]


def needs_of(path: Path) -> list[str]:
    """The missing modules that a file of tests needs."""
    text = path.read_text()
    return [
        name
        for name in MISSING
        if any(f'from {module}' in text or f'import {module}' in text for module in NEEDS[name])
    ]


class Skipped(pytest.Module):
    """A file of tests that is skipped as a whole."""

    def collect(self):
        pytest.skip(f'needs {", ".join(needs_of(self.path))}, which no rosdep key gives')


def pytest_pycollect_makemodule(module_path: Path, parent):
    if needs_of(module_path):
        return Skipped.from_parent(parent, path=module_path)
    return None
