"""ROS messages <-> Frame, Detections, Tracks, Locations.

A message that is inconsistent or violates its contract raises MessageError.
"""

from colortrack_ros.messages.boxes import BOXES
from colortrack_ros.messages.boxes import BoxReader
from colortrack_ros.messages.camera_info import camera_info_of_frame
from colortrack_ros.messages.camera_info import image_size_of_camera_info
from colortrack_ros.messages.camera_info import image_size_of_serialized_camera_info
from colortrack_ros.messages.camera_info import load_camera_info
from colortrack_ros.messages.camera_info import save_camera_info
from colortrack_ros.messages.clouds import cloud_of_detections
from colortrack_ros.messages.clouds import cloud_of_outlines
from colortrack_ros.messages.clouds import cloud_of_tracks
from colortrack_ros.messages.clouds import detections_of_cloud
from colortrack_ros.messages.clouds import detections_of_serialized_cloud
from colortrack_ros.messages.clouds import outlines_of_serialized_cloud
from colortrack_ros.messages.clouds import tracks_of_cloud
from colortrack_ros.messages.clouds import tracks_of_serialized_cloud
from colortrack_ros.messages.clouds import tracks_with_outlines
from colortrack_ros.messages.compressed import compressed_of_frame
from colortrack_ros.messages.compressed import frame_of_serialized_compressed_image
from colortrack_ros.messages.depth import depth_of_serialized_image
from colortrack_ros.messages.depth import image_of_depth
from colortrack_ros.messages.errors import MessageError
from colortrack_ros.messages.header import header_of
from colortrack_ros.messages.header import stamp_of
from colortrack_ros.messages.images import frame_of_image
from colortrack_ros.messages.images import frame_of_serialized_image
from colortrack_ros.messages.images import image_of_frame
from colortrack_ros.messages.locations import cloud_of_locations
from colortrack_ros.messages.locations import locations_of_cloud
from colortrack_ros.messages.locations import locations_of_serialized_cloud
from colortrack_ros.messages.markers import MarkerWriter
from colortrack_ros.messages.motion import odometry_on_ground
from colortrack_ros.messages.motion import speeds_of_serialized_twist
from colortrack_ros.messages.motion import twist_of
from colortrack_ros.messages.serialized import stamp_of_serialized
from colortrack_ros.messages.targets import LocationMarkerWriter
from colortrack_ros.messages.targets import poses_of_locations
from colortrack_ros.messages.targets import target_of_locations

__all__ = [
    'BOXES',
    'BoxReader',
    'LocationMarkerWriter',
    'MarkerWriter',
    'MessageError',
    'camera_info_of_frame',
    'cloud_of_detections',
    'cloud_of_locations',
    'cloud_of_outlines',
    'cloud_of_tracks',
    'compressed_of_frame',
    'depth_of_serialized_image',
    'detections_of_cloud',
    'detections_of_serialized_cloud',
    'frame_of_image',
    'frame_of_serialized_compressed_image',
    'frame_of_serialized_image',
    'header_of',
    'image_of_depth',
    'image_of_frame',
    'image_size_of_camera_info',
    'image_size_of_serialized_camera_info',
    'load_camera_info',
    'locations_of_cloud',
    'locations_of_serialized_cloud',
    'odometry_on_ground',
    'outlines_of_serialized_cloud',
    'poses_of_locations',
    'save_camera_info',
    'speeds_of_serialized_twist',
    'stamp_of',
    'stamp_of_serialized',
    'target_of_locations',
    'tracks_of_cloud',
    'tracks_of_serialized_cloud',
    'tracks_with_outlines',
    'twist_of',
]
