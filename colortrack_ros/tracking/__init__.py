"""Detections -> Tracks: motion models, Kalman bank, association, life of a track."""

from colortrack_ros.tracking.config import TrackerConfig
from colortrack_ros.tracking.tracker import Tracker

__all__ = ['Tracker', 'TrackerConfig']
