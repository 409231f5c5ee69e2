"""Frame -> Detections."""

from colortrack_ros.detection.config import DetectorConfig
from colortrack_ros.detection.detector import Detector
from colortrack_ros.detection.reference import ReferenceColor
from colortrack_ros.detection.regions import Region

__all__ = ['Detector', 'DetectorConfig', 'ReferenceColor', 'Region']
