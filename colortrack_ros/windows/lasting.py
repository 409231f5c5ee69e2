"""Errors of positions that last, which no filter averages: of templates, and of sightings.

A template shows the target a little beside its middle for as long as it is used. An appearance is
that of a target that deforms, whose parts answer to the filter in the next frame as they do now.
"""

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.estimation.box_centers import lasting_variance
from colortrack_ros.estimation.box_centers import variance_of_part
from colortrack_ros.estimation.records import Records
from colortrack_ros.windows.matching import Matches
from colortrack_ros.windows.template import Template


def sizes(records: Records) -> Floats:
    """Return width and height of the N targets' boxes, (N, 2) [px]."""
    return np.stack([records['box_w'], records['box_h']], axis=1)


def biases(records: Records, track: Indices, matches: Matches) -> Floats:
    """Return covariances of what lasts of the errors of sightings, (K, 2, 2) [px^2].

    :param track: (K,) indices of the targets that were sighted in this frame.
    """
    sigma2 = lasting_variance(sizes(records)[track])[..., None]
    return np.asarray(np.nan_to_num(matches.R[track]) + sigma2 * np.eye(2))


def drift(records: Records, i: int, matches: Matches, compensated: bool) -> Floats:
    """Return the covariance of the place of a new template on a target, (2, 2) [px^2].

    It adds to that of the last template, beside which it was found. What has changed since that was
    taken may have been at one side. A sighting owes nothing to templates.

    :param i: the target.
    :param compensated: whether templates are kept as long as they serve.
    """
    if matches.similarity[i] == 0 and compensated:
        return np.array(records['bias'][i])
    total: Floats = records['drift'][i] + np.nan_to_num(matches.R[i])
    if compensated:
        template: Template = records['template'][i]
        kept = template.share_kept(float(matches.similarity[i]))
        total += np.diag(variance_of_part(kept, sizes(records)[i]))
    return total
