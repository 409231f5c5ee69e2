"""Frame -> Detections."""

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
