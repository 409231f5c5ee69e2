"""params/nav2_following.yaml fits the nodes whose place, and whose target, it takes."""

import re

from parameter_pages import NODES
from support.paths import ROOT
from support.pipeline import flat
import yaml

DECLARED = """
controller_frequency detection_timeout rotate_to_object_timeout static_object_timeout
linear_tolerance angular_tolerance max_retries base_frame fixed_frame filter_coef
desired_distance skip_orientation search_by_rotating search_angle odom_topic odom_duration
transform_tolerance controller.k_phi controller.k_delta controller.beta controller.lambda
controller.v_linear_min controller.v_linear_max controller.v_angular_max
controller.slowdown_radius controller.use_collision_detection
"""
"""What the server and its controller declare, as their sources for Jazzy say: of others, as of
misspelled ones, no ROS node tells anything."""


def content(name):
    """Of a file in params/, by node."""
    given = yaml.safe_load((ROOT / 'params' / name).read_text())
    return {node.removeprefix('/**/'): flat(of['ros__parameters']) for node, of in given.items()}


SERVER = content('nav2_following.yaml')['following_server']
WORLD = content('world.yaml')


def default(node, name):
    return NODES[node].find(name).default


def test_the_server_declares_what_it_is_given():
    assert set(SERVER) <= set(DECLARED.split())
    assert content('nav2_following.yaml')['lifecycle_manager_following'] == {
        'autostart': True,
        'node_names': ['following_server'],
    }


def test_frames_and_topics_are_those_of_the_locator_and_the_simulator():
    for node in ('locator', 'simulator', 'follower'):
        for name in ('fixed_frame', 'base_frame', 'odometry_topic'):
            same = SERVER['odom_topic' if name == 'odometry_topic' else name]
            assert WORLD[node].get(name, default(node, name)) == same
    page = (ROOT / 'doc' / 'from_pixels_to_your_robot.md').read_text()
    (topic,) = re.findall(r'pose_topic: /(\w+)', page)
    assert topic == default('locator', 'target_pose_topic')


def test_it_drives_as_the_follower_would():
    follower = WORLD['follower']
    for name, other in (('desired_distance', 'distance'), ('controller.v_linear_max', 'max_speed'),
                        ('controller.v_angular_max', 'max_turn')):  # fmt: skip
        assert SERVER[name] == follower.get(other, default('follower', other))


def test_a_pose_that_is_as_late_as_pictures_are_is_taken_and_no_old_one():
    assert 3 / 30 < SERVER['detection_timeout'] < 0.5
    assert SERVER['controller.use_collision_detection'] is False
