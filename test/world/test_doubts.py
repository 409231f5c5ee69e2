"""What contradicts the camera's pose is found by what is seen, and nothing is published then."""

from dataclasses import replace

import numpy as np
import pytest
from support.balls_seen import RADIUS
from support.balls_seen import seen
from support.misled_robot import BALLS
from support.misled_robot import CAMERA
from support.misled_robot import FRAME
from support.misled_robot import MOUNT
from support.misled_robot import Robot
from support.misled_robot import STANDING
from support.misled_robot import view

from colortrack_ros.data import Detections
from colortrack_ros.data import Tracks
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world import Pose
from colortrack_ros.world.camera import CameraModel
from colortrack_ros.world.config import Kind
from colortrack_ros.world.config import KindConfig
from colortrack_ros.world.poses import OPTICAL
from colortrack_ros.world.search import Pictures

ASIDE = np.array([(2.0, 0.7, RADIUS), (2.0, -0.7, RADIUS)])


def turned(roll=0.0, pitch=0.0, yaw=0.0):
    """The place of the camera, turned about the robot's vertical last."""
    about = Pose.of_rpy(np.zeros(3), (0, 0, yaw)).R
    return Pose(MOUNT.t, about @ (MOUNT @ Pose.of_rpy(np.zeros(3), (roll, pitch, 0))).R)


def scaled(share):
    return CameraModel(
        np.diag([share, share, 1]) @ CAMERA.K, CAMERA.lens, CAMERA.width, CAMERA.height
    )


WRONG = {
    'roll 0 for a camera that is upside down': {'mount': turned(roll=np.pi)},
    'lies on its side': {'mount': turned(roll=np.pi / 2)},
    'looks backward': {'mount': turned(yaw=np.pi)},
    'off by pi/2': {'mount': turned(yaw=-np.pi / 2)},
    'expected of the body': {'mount': MOUNT @ OPTICAL},
    'half as large': {'camera': scaled(0.5)},
    'odometry goes backward': {'odometry': lambda x, yaw: (-x, yaw)},
}


ROLLS = np.array([(3.0, 0.6, RADIUS), (3.5, -0.6, RADIUS)])


@pytest.mark.slow
@pytest.mark.parametrize('line', WRONG)
def test_a_robot_that_drives_finds_the_mistake_names_it_and_publishes_nothing(line):
    """No size is known: nothing but the motion of the robot tells."""
    robot = Robot()
    published = robot.drive(150, **WRONG[line])
    assert published[-60:] == [0] * 60
    assert any(line in told for told in robot.told)
    assert line in robot.locator.doubt


@pytest.mark.slow
@pytest.mark.parametrize('angle', [-40, 30])
def test_a_yaw_that_is_off_by_any_angle_is_found_and_by_how_much(angle):
    robot = Robot()
    published = robot.drive(240, mount=turned(yaw=np.radians(angle)))
    assert published[-60:] == [0] * 60
    line = next(told for told in robot.told if 'the yaw of camera_pose is off by about' in told)
    assert float(line.split()[-2]) == pytest.approx(angle, abs=5)


def old(seconds):
    """Odometry that is so old."""
    ways = []

    def told(*way):
        ways.append(way)
        return ways[max(len(ways) - 1 - round(seconds * 1e9 / FRAME), 0)]

    return told


def longer(share):
    """A calibration with another focal length, and the same center."""
    return replace(CAMERA, K=CAMERA.K * [[share, 1, 1], [1, share, 1], [1, 1, 1]])


AMOUNTS = {
    'the time of odometry (positive: it is old)': (0.2, lambda: {'odometry': old(0.2)}),
    'the focal length of the calibration': (20, lambda: {'camera': longer(1.2)}),
    'the x of camera_pose': (0.3, lambda: {'mount': Pose(MOUNT.t + 0.3 * np.eye(3)[0], MOUNT.R)}),
    'the fx of the calibration, and not its fy,': (
        20, lambda: {'camera': replace(CAMERA, K=CAMERA.K * [[1.2, 1, 1], [1, 1, 1], [1, 1, 1]])}
    ),
    'the first radial coefficient of the distortion': (
        0.28, lambda: {'camera': CameraModel.of(CAMERA.width, CAMERA.height, CAMERA.K)}
    ),
    'the way that odometry tells': (-50, lambda: {'odometry': lambda x, yaw: (x / 2, yaw)}),
    'the roll of camera_pose': (10, lambda: {'mount': turned(roll=np.radians(10))}),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize('about', AMOUNTS)
def test_one_number_of_the_setup_that_is_off_is_found_and_by_how_much(about):
    """Nothing else tells of it: the three balls seem to roll whenever the robot turns."""
    robot, (amount, wrong) = Robot(), AMOUNTS[about]
    published = robot.drive(235, **wrong())
    assert published[-30:] == [0] * 30
    before, told = robot.locator.doubt.split(' is off by about ')
    assert before.endswith(about)
    assert float(told.split()[0]) == pytest.approx(amount, rel=0.15)


@pytest.mark.slow
def test_what_is_said_to_stand_and_does_not_tells_that_something_is_wrong():
    """Odometry that stands while the robot drives: no number that is off explains it."""
    robot = Robot(motion='still')
    published = robot.drive(150, odometry=lambda *_: (0, 0))
    assert published[-30:] == [0] * 30
    assert 'what is said to stand moves whenever the robot does' in robot.locator.doubt


@pytest.mark.slow
@pytest.mark.parametrize('motion', ['still', 'plane'])
def test_what_is_said_to_stand_tells_of_the_camera_whatever_rolls_beside_it(motion):
    """One ball of three stands: enough if it is said to, not if it might move as the others."""
    robot, wrong = Robot(), {'mount': turned(yaw=np.pi / 2)}
    kinds = [Kind(name, KindConfig(height=RADIUS, motion=m))
             for name, m in (('red', 'plane'), ('green', motion))]  # fmt: skip
    robot.locator.configure(LocatorConfig(colors=tuple(kinds)))
    robot.thrown, stands = True, np.array([(2.5, -0.4, 1.5 * RADIUS)])
    for k in range(120):
        away = np.array([0.02, 0.01, 0]) * k
        rolled = ROLLS + np.stack([away, away * [1, -0.5, 0]])
        robot.see(np.concatenate([rolled, stands]), **wrong)
    assert bool(robot.locator.doubt) == (motion == 'still')


@pytest.mark.slow
@pytest.mark.parametrize('roll', [0, np.pi])
def test_a_wrong_sign_of_the_pitch_is_found_also_of_a_camera_that_is_upside_down(roll):
    really, told = (Pose.of_rpy((0.1, 0, 0.5), (roll, pitch, 0)) for pitch in (0.15, -0.15))
    robot = Robot()
    assert sum(robot.drive(150, mount=told, really=really)[-60:]) == 0
    assert 'the pitch of camera_pose has the wrong sign' in robot.locator.doubt


@pytest.mark.parametrize('line', ['upside down', 'on its side', 'half as large'])
def test_where_the_size_is_known_nothing_is_published_from_the_first_picture_on(line):
    (wrong,) = (wrong for name, wrong in WRONG.items() if line in name)
    robot = Robot(told_diameter=2 * RADIUS)
    assert sum(robot.drive(STANDING, **wrong)) == 0
    assert robot.told
    assert robot.locator.doubt


def test_what_is_located_by_its_size_does_not_speak_for_a_camera_that_is_upside_down():
    robot = Robot(told_diameter=2 * RADIUS, thrown=True)
    balls, wrong = np.append(BALLS, [(3.0, 0.3, 0.5)], axis=0), {'mount': turned(roll=np.pi)}
    robot.drive(5, balls=balls, **wrong)
    assert sum(robot.drive(STANDING, balls=balls[3:], ids=[4], **wrong)) == 0
    assert robot.locator.doubt


@pytest.mark.slow
def test_a_mistake_that_is_mended_is_forgotten_while_the_robot_drives():
    robot = Robot()
    robot.drive(120, mount=turned(roll=np.pi))
    assert robot.locator.doubt
    robot.drive(200)
    assert not robot.locator.doubt
    assert robot.drive(1) == [3]


@pytest.mark.slow
@pytest.mark.parametrize('count', [1, 3])
def test_what_really_rolls_contradicts_nothing(count):
    robot, balls = Robot(told_diameter=2 * RADIUS), BALLS[:count].copy()
    for _ in range(150):
        balls[:, :2] += np.array([[0.02, 0.004], [0.01, 0.002], [0.015, -0.002]])[:count]
        assert len(robot.see(balls).rows) == count
    assert robot.told == []


def test_one_object_of_another_size_is_not_published_and_the_others_are():
    robot = Robot(told_diameter=2 * RADIUS)
    tracks, detections = seen(view(0, 0), BALLS, FRAME)
    detections.rows['area'][0] *= 4
    for name in ('box_w', 'box_h'):
        detections.rows[name][0] *= 2
    for name in ('area', 'box_w', 'box_h'):
        tracks.rows[name][2] = detections.rows[name][0]
    out = robot.locator.update(tracks, detections, view(0, 0))
    assert out.rows['track_id'].tolist() == [1, 2]
    assert 'px large, expected' in robot.told[0]
    assert not robot.locator.doubt


@pytest.mark.slow
def test_what_goes_behind_something_is_not_told_to_be_too_small():
    """A pillar covers the left sixth of a ball, which still has nearly the shape of a disc."""
    robot = Robot(told_diameter=2 * RADIUS)
    robot.drive(STANDING + 90)
    for _ in range(20):
        tracks, detections = seen(view(0.9, 0), BALLS, (robot.k + 1) * FRAME)
        robot.k += 1
        width = detections.rows['box_w'][0]
        for rows, one in ((detections.rows, 0), (tracks.rows, 2)):
            rows['box_w'][one] *= 5 / 6
            rows['area'][one] *= 0.77
        detections.rows['u'][0] += width / 12
        detections.rows['box_u'][0] += width / 6
        robot.locator.update(tracks, detections, view(0.9, 0))
    assert robot.told == []


def test_what_is_held_above_the_ground_is_told_and_published_by_size():
    robot = Robot(told_diameter=2 * RADIUS, method='size')
    held = BALLS + np.array([0, 0, 0.4])
    assert robot.drive(5, balls=held) == [3] * 5
    assert 'm off the height' in robot.told[0]


def test_what_is_located_below_the_ground_is_not_published():
    robot = Robot(told_diameter=2 * RADIUS, method='size')
    low = Pose(MOUNT.t * [1, 1, -1], MOUNT.R)
    assert robot.drive(5, mount=low) == [0] * 5
    assert 'm off the height' in robot.told[0]


@pytest.mark.slow
def test_pictures_without_objects_and_clocks_that_go_back_are_no_evidence():
    robot = Robot()
    robot.drive(60)
    robot.k = 10
    robot.drive(60)
    for k in range(60):
        stamp = (200 + k) * FRAME
        robot.locator.update(Tracks(stamp=stamp), Detections(stamp=stamp), view(0.01 * k, 0))
    assert not robot.locator.doubt


def test_sizes_of_all_objects_together_tell_what_none_tells_alone():
    """Rolled by 10 degrees: each ball could be so large by a pitch that is off by itself."""
    robot = Robot(2 * RADIUS)
    wrong = robot.drive(STANDING, mount=turned(roll=np.radians(8)), balls=ASIDE)
    assert wrong[0] == len(ASIDE)
    assert wrong[-1] == 0
    assert 'does not fit together' in robot.locator.doubt
    assert len(set(robot.told)) <= 3


def test_a_camera_off_by_as_much_as_is_expected_is_believed():
    robot = Robot(2 * RADIUS)
    right = robot.drive(STANDING, mount=turned(roll=0.015, pitch=-0.015), balls=ASIDE)
    assert right == [len(ASIDE)] * STANDING
    assert robot.told == []


@pytest.mark.slow
def test_odometry_that_is_said_to_be_poor_is_no_mistake():
    """Stamps off by 10 ms while the robot turns: what is said to stand seems to move by as much."""
    rng = np.random.default_rng(1)

    def shaken(x, yaw):
        return x, yaw + 0.01 * rng.normal()

    said, unsaid = Robot(motion='still', odometry_sigma=(0.02, 0.02)), Robot(motion='still')
    assert said.drive(150, odometry=shaken)[-1] == len(BALLS)
    assert not said.locator.doubt
    unsaid.drive(150, odometry=shaken)
    assert 'what is said to stand moves' in unsaid.locator.doubt


@pytest.mark.slow
def test_a_search_tries_a_few_hypotheses_in_each_picture(monkeypatch):
    """All of them at once would take as long as there is between two pictures."""
    tried, misfits = [], Pictures.misfits

    def counted(pictures, mistakes):
        tried[-1] += len(mistakes)
        return misfits(pictures, mistakes)

    monkeypatch.setattr(Pictures, 'misfits', counted)
    robot, wrong = Robot(), WRONG['half as large']
    while not robot.locator.doubt:
        tried.append(0)
        robot.drive(1, **wrong)
    assert sum(tried) > 100
    assert max(tried) <= 12
