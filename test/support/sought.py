"""A detector that finds the tolerances of its colors."""

from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor


def sought(*colors):
    """A detector of colors, (r, g, b) each, named c0, c1, and so on."""
    named = [ReferenceColor.from_rgb(f'c{k}', rgb) for k, rgb in enumerate(colors)]
    return Detector(DetectorConfig(colors=tuple(named)))
