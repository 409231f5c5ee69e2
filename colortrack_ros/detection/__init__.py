"""Frame -> Detections."""

from colortrack_ros.detection.config import DetectorConfig
from colortrack_ros.detection.config import ReferenceColor
from colortrack_ros.detection.detector import Detector

__all__ = ['Detector', 'DetectorConfig', 'ReferenceColor']
