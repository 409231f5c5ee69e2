"""tracking: detections in, tracks out: gating, association, update, initiation and deletion."""

from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.tracker import Tracker

__all__ = ['Tracker', 'TrackerConfig']
