"""drawing: draws tracks onto pictures for people to look at."""

from colortrack_ros.drawing.overlay import draw_tracks
from colortrack_ros.drawing.overlay import track_color
from colortrack_ros.drawing.top_view import TopView
from colortrack_ros.drawing.trails import Trails
from colortrack_ros.drawing.video import VideoFile
from colortrack_ros.drawing.video import write_picture

__all__ = ['TopView', 'Trails', 'VideoFile', 'draw_tracks', 'track_color', 'write_picture']
