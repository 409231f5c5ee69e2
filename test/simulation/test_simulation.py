"""The simulated room is what its parameters say, and its pictures are what a camera would see."""

import sys

import numpy as np
import pytest
from support.paths import ROOT

from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.simulation import Simulation
from colortrack_ros.simulation import SimulationConfig
from colortrack_ros.simulation import Thing
from colortrack_ros.simulation import ThingConfig
from colortrack_ros.simulation.course import Course
from colortrack_ros.world.state import GRAVITY

sys.path.append(str(ROOT / 'benchmark'))

from following import ROLLING
from following import Run
from following import STANDING
from following import swing
from following import SWINGING

SECOND = 1_000_000_000
RED = np.array([34, 58, 205])


def room(*configs, **parameters):
    things = tuple(Thing(f'thing{k}', config) for k, config in enumerate(configs))
    return Simulation(
        SimulationConfig(**{'room': 'empty', 'objects': things, 'picture_noise': 0.0} | parameters)
    )


def pixels_of(image, color=RED):
    """u, v of the pixels of a color, whatever the light."""
    shade = image.astype(float) / np.maximum(image.max(axis=2, keepdims=True), 1)
    v, u = (np.abs(shade - color / color.max()).max(axis=2) < 0.05).nonzero()
    return np.stack([u, v], axis=1)


@pytest.mark.slow
@pytest.mark.parametrize('place', [(1.5, 0.0), (2.5, 1.2), (3.0, -1.4)])
def test_a_ball_is_seen_where_the_lens_shows_it_and_as_far_away_as_it_is(place):
    simulation = room(ThingConfig(path=place))
    sight = simulation.look()
    center = np.array([[*place, 0.1]])
    optical = simulation.view.optical
    seen = pixels_of(sight.image)
    (expected,) = simulation.camera.project(optical.inverse().apply(center))
    # the picture of a sphere is an ellipse whose center lies farther out than that of the sphere
    assert seen.mean(axis=0) == pytest.approx(expected, abs=1.0)
    middle = sight.depth[round(expected[1]), round(expected[0])]
    depth = optical.inverse().apply(center)[0, 2]
    assert middle == pytest.approx(depth - 0.1, abs=0.02)
    assert sight.visible == pytest.approx([1.0], abs=0.15)


@pytest.mark.slow
def test_depths_of_the_floor_lead_to_the_floor():
    simulation = room()
    depth = simulation.look().depth
    u, v = np.array([20, 320, 600]), np.array([400, 470, 440])
    points = simulation.camera.unproject(np.stack([u, v], axis=1).astype(float), depth[v, u])
    assert simulation.view.optical.apply(points)[:, 2] == pytest.approx(0.0, abs=1e-3)


@pytest.mark.slow
def test_what_is_behind_a_post_or_the_camera_is_not_seen_and_truth_says_so():
    post = ThingConfig(shape='cylinder', rgb=(90, 90, 90), diameter=0.5, height=1.5, path=(1.5, 0))
    simulation = room(post, ThingConfig(path=(2.5, 0)), ThingConfig(path=(-1.0, 0)))
    sight = simulation.look()
    assert len(pixels_of(sight.image)) == 0
    rows = simulation.truth(sight.visible).rows
    assert rows['state'].tolist() == [CONFIRMED, COASTING, COASTING]
    simulation.advance(SECOND)
    rows = simulation.truth(simulation.look().visible).rows
    assert rows['time_since_update'].tolist() == [0.0, 1.0, 1.0]


@pytest.mark.slow
def test_the_lid_of_a_post_below_the_camera_is_seen():
    simulation = room(ThingConfig(shape='cylinder', diameter=0.6, height=0.2, path=(1.5, 0)))
    depth = simulation.look().depth
    lid = np.array([[1.5, 0.0, 0.2]])
    (pixel,) = simulation.camera.project(simulation.view.optical.inverse().apply(lid)).round()
    point = simulation.camera.unproject(pixel[None], depth[[int(pixel[1])], [int(pixel[0])]])
    assert simulation.view.optical.apply(point)[0, 2] == pytest.approx(0.2, abs=1e-3)


@pytest.mark.slow
def test_things_beside_and_around_the_camera_leave_no_trace_where_they_are_not():
    empty = room().look().image
    beside = room(ThingConfig(shape='cylinder', diameter=0.3, height=1.5, path=(0.1, 1.5)))
    assert (beside.look().image == empty).all()


def test_a_thing_goes_its_path_at_its_speed_around_corners_and_again():
    course = Course(ThingConfig(path=(0, 0, 2, 0, 2, 1), speed=0.5))
    assert course.at(3.0)[0].tolist() == [1.5, 0, 0.1]
    assert course.at(4.5)[0] == pytest.approx([2, 0.25, 0.1])
    assert course.at(4.5)[1] == pytest.approx([0, 0.5, 0])
    around = (3 + np.sqrt(5)) / 0.5
    assert course.at(4.5 + around)[0] == pytest.approx([2, 0.25, 0.1])


def test_what_bounces_falls_freely_and_never_into_the_ground():
    course = Course(ThingConfig(path=(1, 1), bounce_height=0.8, restitution=0.7))
    states = np.array([np.concatenate(course.at(t)) for t in np.arange(0, 10, 0.01)])
    height, up = states[:, 2] - 0.1, states[:, 5]
    assert height.min() >= 0
    assert height.max() == pytest.approx(0.8, abs=0.001)
    falls = np.diff(up) < 0
    assert np.diff(up)[falls] == pytest.approx(-0.01 * GRAVITY)
    means = (up[1:] + up[:-1])[falls] / 2
    assert np.diff(height)[falls] == pytest.approx(0.01 * means, abs=1e-9)


def dark_room(*configs, **parameters):
    """One whose pictures nobody looks at: to have the rays of each pixel takes longest."""
    return room(*configs, picture_size=(16, 16), **parameters)


def drive(simulation, speed, turn, seconds, ticks=50):
    simulation.robot.command(speed, turn)
    for _ in range(round(seconds * ticks)):
        simulation.advance(SECOND // ticks)


@pytest.mark.slow
def test_a_robot_drives_the_circle_that_it_is_told():
    simulation = dark_room()
    drive(simulation, 0.5, 0.5, 2 * np.pi / 0.5)
    robot = simulation.robot
    # it starts from standing: 0.1 s at half of the speed
    assert (robot.place.x, robot.place.y) == pytest.approx((0, 0), abs=0.06)
    assert robot.odometry == robot.place
    half = dark_room()
    drive(half, 0.5, 0.5, np.pi / 0.5)
    assert half.robot.place.y == pytest.approx(2.0, abs=0.06)


@pytest.mark.slow
def test_a_robot_stops_at_walls_and_things():
    simulation = dark_room(ThingConfig(path=(2.0, 0.0)))
    drive(simulation, 1.0, 0.0, 5.0)
    assert simulation.robot.place.x == pytest.approx(1.7, abs=0.05)
    simulation = dark_room()
    drive(simulation, 1.0, 0.0, 8.0)
    assert simulation.robot.place.x == pytest.approx(5.8, abs=0.05)


@pytest.mark.slow
def test_odometry_drifts_by_as_much_as_was_asked_for():
    ends = []
    for seed in range(200):
        simulation = dark_room(odometry_drift=(0.03, 0.05), seed=seed)
        drive(simulation, 1.0, 0.0, 4.1, ticks=10)
        ends.append(simulation.robot.odometry.x - simulation.robot.place.x)
    assert np.std(ends) == pytest.approx(0.06, rel=0.2)
    assert np.mean(ends) == pytest.approx(0.0, abs=0.02)


@pytest.mark.slow
def test_truth_is_in_the_frame_of_the_odometry_that_drifts():
    simulation = room(ThingConfig(path=(3, 1)), odometry_drift=(0.2, 0.2))
    drive(simulation, 0.5, 0.5, 3.0)
    (row,) = simulation.truth(simulation.look().visible).rows
    robot = simulation.robot
    assert robot.odometry != robot.place
    theirs = robot.odometry.pose.inverse().apply(np.array([[row['x'], row['y'], row['z']]]))
    ours = robot.place.pose.inverse().apply(np.array([[3.0, 1.0, 0.1]]))
    assert theirs == pytest.approx(ours, abs=1e-5)


def test_a_path_of_half_a_corner_is_refused_with_what_a_path_is():
    with pytest.raises(ValueError, match='expected x and y of each corner'):
        ThingConfig(path=(1.0, 2.0, 3.0))


def test_a_camera_that_no_calibration_may_have_is_refused_with_the_other_parameters():
    """So that the node starts with the default, in place of ending."""
    with pytest.raises(ValueError, match='calibration with fx 30'):
        SimulationConfig(focal_length=30.0)


@pytest.mark.slow
def test_depths_of_a_stereo_camera_err_with_the_square_and_have_holes_at_edges_and_elsewhere():
    true = room(ThingConfig(path=(2.0, 0.0))).look().depth
    seen = room(ThingConfig(path=(2.0, 0.0)), depth_noise=0.005).look().depth
    ratio = (seen - true) / (0.005 * true**2)
    assert np.nanstd(ratio) == pytest.approx(1.0, abs=0.05)
    assert abs(np.nanmean(ratio)) < 0.05
    holes = np.isnan(room(ThingConfig(path=(2.0, 0.0)), depth_holes=0.2).look().depth)
    assert 0.2 < holes.mean() < 0.3
    outline = np.abs(np.diff(true, axis=1)) > 0.5
    assert outline.sum() > 20
    assert holes[:, 1:][outline].all()
    assert np.isnan(room(depth_holes=1.0).look().depth).all()


@pytest.mark.slow
def test_through_noise_and_holes_of_depth_things_are_located_within_a_hundredth_of_the_range():
    """Driving and turning, with an error in each depth of 2 cm at 2 m and half of them lost."""
    run = Run(
        0, ROLLING, 'depth', room='empty', objects=STANDING, depth_noise=0.005, depth_holes=0.5
    )
    run.go(SWINGING, swing)
    error, away, speed = np.array(run.found).T
    near = (away > 1) & (away < 5)
    assert np.count_nonzero(near) > 200
    assert np.sqrt(np.mean((error[near] / away[near]) ** 2)) < 0.01
    assert np.mean(speed < 0.05) > 0.95
    assert [len(ids) for ids in run.ids.values()] == [1, 1, 1]
