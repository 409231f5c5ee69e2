"""Errors of positions that last, which no filter averages: of templates, and of sightings.

A template shows the target a little beside its middle for as long as it is used, as its first box
was drawn. An appearance is that of a target that deforms, whose parts answer to the filter in the
next frame as they do now.
"""

import numpy as np

from colortrack_ros.data import Floats
from colortrack_ros.data import Indices
from colortrack_ros.estimation.box_centers import LASTING_SHARE
from colortrack_ros.estimation.box_centers import lasting_variance
from colortrack_ros.estimation.box_centers import variance_of_part
from colortrack_ros.estimation.records import Records
from colortrack_ros.windows.matching import Matches
from colortrack_ros.windows.template import Template


def sizes(records: Records) -> Floats:
    """Return width and height of the N targets' boxes, (N, 2) [px]."""
    return np.stack([records['box_w'], records['box_h']], axis=1)


def biases(records: Records, track: Indices, matches: Matches, box_error: float) -> Floats:
    """Return covariances of what lasts of the errors of matches, (K, 2, 2) [px^2].

    A template shows where the middle of the first box has gone, which is as far off the target's
    now as it was then. An appearance has learned more than that box.

    :param track: (K,) indices of the targets that were measured in this frame.
    :param box_error: see WindowConfig.
    """
    sighted = matches.similarity[track] == 0
    share = np.where(sighted, LASTING_SHARE, box_error)
    R = np.where(sighted[:, None, None], np.nan_to_num(matches.R[track]), 0.0)
    return np.asarray(R + bias_of_box(sizes(records)[track], share[:, None]))


def bias_of_box(size: Floats, share: float | Floats) -> Floats:
    """Return covariances of how far the middle of a box is off its target's, (K, 2, 2) [px^2].

    :param size: (K, 2) width and height of the boxes [px].
    :param share: standard deviation over the longer side, of all or of each, (K, 1).
    """
    return np.asarray(lasting_variance(size, share)[..., None] * np.eye(2))


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
