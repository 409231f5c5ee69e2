"""detection: frames in, detections out.

``Detector.detect`` (detector.py) asks a method (methods/, one file each) to label each pixel. Color
distance does so with lookup tables (color_table.py) of CIELAB (lab.py). The label image then passes
through regions.py, morphology.py, blobs.py, split.py and shape.py; covariance.py gives each blob a
covariance.
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
