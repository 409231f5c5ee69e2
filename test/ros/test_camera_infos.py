"""CameraInfo that changes while a robot drives, as drivers that bin or crop send it."""

from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
import pytest
from sensor_msgs.msg import CameraInfo
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2
from sensor_msgs.msg import RegionOfInterest
from support.ball_before_camera import BALL
from support.ball_before_camera import info
from support.ball_before_camera import picture
from support.ball_before_camera import PLACE
from support.ball_before_camera import seen_by
from support.ball_before_camera import START
from support.locating_robot import FRAME
from support.locating_robot import Robot

from colortrack_ros.data import Frame
from colortrack_ros.messages import image_of_frame
from colortrack_ros.messages import locations_of_cloud
from colortrack_ros.world import CameraModel
from colortrack_ros.world import Pose
from colortrack_ros.world.view import View

MOUNT = Pose.of_rpy(PLACE[:3], PLACE[3:])
PART = {
    'binning_x': 2,
    'binning_y': 2,
    'roi': RegionOfInterest(x_offset=60, y_offset=40, width=560, height=420),
}


def part_of_sensor(stamp):
    message = info(stamp)
    for name, value in PART.items():
        setattr(message, name, value)
    return message


def test_each_picture_is_located_by_its_own_calibration(ros):
    """The one of the next picture, which is of a part of the sensor, comes first: detectors are
    slower than drivers."""
    robot = Robot(ros, patient=True)
    infos = [info(START + k * FRAME) for k in range(10)]
    infos += [part_of_sensor(START + k * FRAME) for k in range(10, 20)]
    robot.info.publish(infos[0])
    ros.settle()
    for k in range(19):
        robot.drive(k)
        robot.info.publish(infos[k + 1])
        ros.settle()
        base = Pose.of_rpy((0.02 * k, 0, 0), (0, 0, 0))
        view = View(CameraModel.of_info(infos[k]), base, MOUNT)
        for publisher, cloud in zip(
            (robot.detections, robot.tracks), seen_by(START + k * FRAME, view), strict=True
        ):
            publisher.publish(cloud)
        assert ros.spin(lambda k=k: len(robot.locations) == k + 1), ros.outputs()
        (row,) = locations_of_cloud(robot.locations[-1]).rows
        assert (row['x'], row['y']) == pytest.approx(BALL[:2], abs=0.02), k
    robot.node.wait_for('the camera has been calibrated anew: objects restart')


def test_the_calibration_of_another_camera_is_told_by_its_frame(ros):
    """As of the right camera of a pair: nothing else tells it from that of the left one."""
    robot = Robot(ros, patient=True)
    other = info(START)
    other.header.frame_id = 'right'
    robot.info.publish(other)
    ros.settle()
    robot.drive(0)
    for publisher, cloud in zip((robot.detections, robot.tracks), picture(START, 0.0), strict=True):
        publisher.publish(cloud)
    robot.node.wait_for(
        "CameraInfo on camera/camera_info is of frame 'right', and pictures are of 'cam'"
    )
    assert ros.spin(lambda: len(robot.locations) == 1), ros.outputs()


def detector_of(ros, change, **parameters):
    """A detector that has seen 25 pictures of 64x48, each with a CameraInfo as it is changed."""
    detector = ros.start('detector', **parameters)
    seen = ros.listen(PointCloud2, 'detections')
    pictures = ros.node.create_publisher(Image, 'camera/image_raw', 10)
    infos = ros.node.create_publisher(CameraInfo, 'camera/camera_info', 10)
    for publisher in (pictures, infos):
        assert ros.spin(lambda p=publisher: p.get_subscription_count() == 1), ros.outputs()
    ros.settle()
    for k in range(25):
        frame = Frame(np.zeros((48, 64, 3), np.uint8), 'bgr8', START + k * FRAME, 'cam')
        message = CameraInfo(width=64, height=48)
        message.header = image_of_frame(frame).header
        change(message)
        infos.publish(message)
        pictures.publish(image_of_frame(frame))
        assert ros.spin(lambda k=k: len(seen) == k + 1), ros.outputs()
    return detector


def calibrated_for_larger_ones(message):
    message.width, message.height = 80, 60


def test_the_calibration_of_larger_pictures_is_told(ros):
    """All objects were located elsewhere, and before a robot that stands nothing told it."""
    detector_of(ros, calibrated_for_larger_ones).wait_for(
        'CameraInfo on camera/camera_info is of 80x60 pictures, those on camera/image_raw have '
        '64x48: what locates by it is wrong; calibrate the camera for this size, or set '
        'camera_info_topic to that of these pictures'
    )


def test_one_trouble_of_a_detector_does_not_hide_the_other(ros):
    """Whoever saw that of the size alone looked there for why nothing was found."""
    diagnostics = ros.listen(DiagnosticArray, '/diagnostics')
    shares = {'regions': '[door]', 'door.polygon': '[0.1, 0.1, 0.9, 0.1, 0.5, 0.9]'}
    detector = detector_of(ros, calibrated_for_larger_ones, **shares)
    size, nowhere = 'is of 80x60 pictures', 'regions and mask leave'

    def told() -> str:
        return next((s.message for m in diagnostics for s in m.status if size in s.message), '')

    assert ros.spin(lambda: told() != ''), ros.outputs()
    assert 0 < told().find(size) < told().find(nowhere)
    for text in (size, nowhere):
        assert detector.output.count(text) == 1


def binned(message):
    message.width, message.height, message.binning_x, message.binning_y = 129, 96, 2, 2


def of_another_camera(message):
    message.width, message.header.frame_id = 80, 'other'


@pytest.mark.parametrize('change', [binned, of_another_camera, lambda message: None])
def test_of_a_calibration_that_fits_nothing_is_told(ros, change):
    assert 'pictures, those on' not in detector_of(ros, change).output
