"""The table of what each mechanism of the tracker is worth can be made: no row is out of date."""

import sys

import pytest
from support.paths import ROOT

sys.path.append(str(ROOT / 'benchmark'))

import ablation
from points import of_scene


@pytest.fixture(scope='module')
def broken():
    """Balls that fall to pieces."""
    return of_scene('flicker?width=640&height=360&duration=1.5')


@pytest.mark.parametrize('name', ablation.WITHOUT)
def test_every_row_can_be_measured(name, broken):
    changes, patches = ablation.WITHOUT[name]
    idf1, _ = ablation.measure(changes, patches, [broken])
    assert 30 < idf1 <= 100
