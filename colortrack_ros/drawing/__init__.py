"""drawing: tracks onto a picture, for people."""

from colortrack_ros.drawing.overlay import draw_tracks
from colortrack_ros.drawing.overlay import track_color
from colortrack_ros.drawing.trails import Trails

__all__ = ['Trails', 'draw_tracks', 'track_color']
