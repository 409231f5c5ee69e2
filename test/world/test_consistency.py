"""What does not fit together as configured, and when it does again."""

import numpy as np
import pytest

from colortrack_ros.world import LocatorConfig
from colortrack_ros.world.belief import Belief
from colortrack_ros.world.checks import BlobSizes
from colortrack_ros.world.consistency import inconsistency

PITCH = 4
NO_SIZES = BlobSizes(np.zeros(0, bool), np.zeros(0), np.zeros(0), np.zeros((0, 0)))


@pytest.mark.parametrize(
    ('off', 'reported', 'still'),
    [(5.5, False, True), (4.5, False, False), (4.5, True, True), (2.5, True, False)],
)
def test_what_did_not_fit_together_still_does_not_until_it_fits_well(off, reported, still):
    """A pitch that is off by so many standard deviations, known to a tenth of one."""
    belief = Belief.of(LocatorConfig(method='size'))
    belief.errors.mean[:, PITCH] = 0.01 * off
    belief.errors.cov[:, PITCH, PITCH] *= 0.01
    assert bool(inconsistency(belief, 0, NO_SIZES, reported)) == still
