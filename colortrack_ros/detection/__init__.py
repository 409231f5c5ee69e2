"""Frame -> Detections.

The way of a frame: ``Detector.detect`` (detector.py) asks a method (methods/, one file each) for
the label of each pixel, the color distance by tables (color_table.py) of CIELAB (lab.py). What is
labeled passes regions.py, morphology.py, blobs.py, split.py and shape.py, and gets a covariance
(covariance.py).
"""

from colortrack_ros.detection.config import DetectorConfig
from colortrack_ros.detection.detector import Detector
from colortrack_ros.detection.pick import pick_color
from colortrack_ros.detection.pick import PickedColor
from colortrack_ros.detection.pick import side_by_side
from colortrack_ros.detection.reference import ReferenceColor
from colortrack_ros.detection.regions import Region

__all__ = [
    'Detector',
    'DetectorConfig',
    'PickedColor',
    'ReferenceColor',
    'Region',
    'pick_color',
    'side_by_side',
]
