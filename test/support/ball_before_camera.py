"""The messages of a ball before the camera of a robot, as a detector and a tracker send them."""

from nav_msgs.msg import Odometry
import numpy as np
from sensor_msgs.msg import CameraInfo
from support.balls_seen import seen

from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import TRACK
from colortrack_ros.data import Tracks
from colortrack_ros.messages import cloud_of_detections
from colortrack_ros.messages import cloud_of_tracks
from colortrack_ros.messages import header_of
from colortrack_ros.world import CameraModel
from colortrack_ros.world import Pose
from colortrack_ros.world.view import View

K = (520.0, 0.0, 320.0, 0.0, 520.0, 240.0, 0.0, 0.0, 1.0)
PLACE = (0.1, 0.0, 0.5, 0.0, 0.25, 0.0)
BALL = (3.0, 0.4, 0.1)
START = 10**18


def info(stamp, k=K):
    return CameraInfo(
        header=header_of(stamp, 'cam'), width=640, height=480, distortion_model='plumb_bob', k=k
    )


def odometry(stamp, x, frame='odom', child='base_link', yaw=0.0):
    message = Odometry(header=header_of(stamp, frame), child_frame_id=child)
    message.pose.pose.position.x = x
    turn = message.pose.pose.orientation
    turn.w, turn.z = float(np.cos(yaw / 2)), float(np.sin(yaw / 2))
    return message


def view_of(base, mount):
    """The camera on a robot at a pose."""
    return View(CameraModel.of(640, 480, K), base, mount)


def picture(stamp, x, yaw=0.0):
    """Clouds of the detections and tracks of the ball, seen by a robot at x."""
    mount = Pose.of_rpy(PLACE[:3], PLACE[3:])
    return seen_by(stamp, view_of(Pose.of_rpy((x, 0, 0), (0, 0, yaw)), mount))


def seen_by(stamp, view):
    """Clouds of the detections and tracks of the ball, seen by a camera."""
    detections, track = seen(view, BALL, stamp)[1], np.zeros(1, TRACK)
    for name in ('u', 'v', 'area', 'box_u', 'box_v', 'box_w', 'box_h'):
        track[name] = detections.rows[name]
    track['track_id'], track['state'] = 7, CONFIRMED
    return cloud_of_detections(detections), cloud_of_tracks(Tracks(track, stamp, 'cam'))
