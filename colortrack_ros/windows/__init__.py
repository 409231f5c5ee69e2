"""Frame -> Tracks: window matching, supervised by a Kalman filter and a swarm of particles."""

from colortrack_ros.windows.config import WindowConfig
from colortrack_ros.windows.tracker import WindowTracker

__all__ = ['WindowConfig', 'WindowTracker']
