"""A robot with a locator, before a ball: what it publishes, what it hears."""

from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo
from sensor_msgs.msg import PointCloud2
from support.ball_before_camera import info
from support.ball_before_camera import K
from support.ball_before_camera import odometry
from support.ball_before_camera import picture
from support.ball_before_camera import PLACE
from support.ball_before_camera import seen_by
from support.ball_before_camera import START
from support.forks import program_of

FRAME = 40_000_000
RED = {
    'colors': '[red]',
    'red.diameter': 0.2,
    'camera_pose': str([float(number) for number in PLACE]),
}

WAITING_LONG = """
from colortrack_ros.world import waiting
waiting.LONGEST_WAIT = 100.0
"""


class Robot:
    """A robot that drives at 0.5 m/s towards a ball: what it publishes, what it hears."""

    def __init__(self, ros, *, patient=False, **parameters):
        """patient: the locator waits for odometry for as long as a busy machine may need."""
        self.ros = ros
        code = WAITING_LONG * patient + program_of('locator')
        self.node = ros.start_code(code, **(RED | parameters))
        make = ros.node.create_publisher
        self.info = make(CameraInfo, 'camera/camera_info', 10)
        self.odometry = make(Odometry, 'odom', 10)
        self.detections = make(PointCloud2, 'detections', 10)
        self.tracks = make(PointCloud2, 'tracks', 10)
        self.locations = ros.listen(PointCloud2, 'locations')
        publishers = [self.info, self.detections, self.tracks]
        if parameters.get('pose_source') != 'tf':
            publishers.append(self.odometry)
        assert ros.spin(lambda: all(p.get_subscription_count() for p in publishers)), ros.outputs()
        assert ros.spin(lambda: ros.node.count_publishers('locations') == 1)
        ros.settle()

    def see(self, k, k_of_camera=K, view=None):
        stamp = START + k * FRAME
        self.info.publish(info(stamp, k_of_camera))
        self.ros.settle()  # which of two topics is heard first nobody can tell otherwise
        clouds = seen_by(stamp, view) if view else picture(stamp, 0.02 * k)
        for publisher, cloud in zip((self.detections, self.tracks), clouds, strict=True):
            publisher.publish(cloud)

    def drive(self, k, **names):
        self.odometry.publish(odometry(START + k * FRAME, 0.02 * k, **names))
