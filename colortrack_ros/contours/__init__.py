"""Frame -> Tracks: contours of what has moved, followed by the edges along their normals."""

from colortrack_ros.contours.config import ContourConfig
from colortrack_ros.contours.tracker import ContourTracker

__all__ = ['ContourConfig', 'ContourTracker']
