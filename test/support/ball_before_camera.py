"""The messages of a ball before the camera of a robot, as a detector and a tracker send them."""

from nav_msgs.msg import Odometry
import numpy as np
from sensor_msgs.msg import CameraInfo

from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import TRACK
from colortrack_ros.data import Tracks
from colortrack_ros.messages import cloud_of_detections
from colortrack_ros.messages import cloud_of_tracks
from colortrack_ros.messages import header_of
from colortrack_ros.world import CameraModel
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world import Pose
from colortrack_ros.world.measurement import BLOB
from colortrack_ros.world.measurement import expected
from colortrack_ros.world.view import View

K = (520.0, 0.0, 320.0, 0.0, 520.0, 240.0, 0.0, 0.0, 1.0)
PLACE = (0.1, 0.0, 0.5, 0.0, 0.25, 0.0)
BALL = (3.0, 0.4, 0.1)
DIAMETER = 0.2
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


def picture(stamp, x, yaw=0.0):
    """Clouds of the detections and tracks of the ball, seen by a robot at x."""
    camera = CameraModel.of(640, 480, K)
    view = View(camera, Pose.of_rpy((x, 0, 0), (0, 0, yaw)), Pose.of_rpy(PLACE[:3], PLACE[3:]))
    mean = np.zeros((1, 16))
    mean[0, :3] = BALL
    z = expected(view, mean, np.array([DIAMETER]), np.zeros(1))[0][0]
    row, track = np.zeros(1, DETECTION), np.zeros(1, TRACK)
    row['u'], row['v'], row['cov_uu'], row['cov_vv'] = z[0], z[1], 0.01, 0.01
    size = z[BLOB] - LocatorConfig().eroded
    row['box_w'] = row['box_h'] = track['box_w'] = track['box_h'] = size
    row['area'] = track['area'] = np.pi / 4 * size**2
    row['box_u'], row['box_v'] = z[0] - size / 2, z[1] - size / 2
    track['u'], track['v'], track['track_id'], track['state'] = z[0], z[1], 7, CONFIRMED
    return (
        cloud_of_detections(Detections(row, stamp, 'cam')),
        cloud_of_tracks(Tracks(track, stamp, 'cam')),
    )
