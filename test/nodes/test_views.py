"""The RViz configuration and the Foxglove layout show what the nodes publish."""

import json

import parameter_pages
import pytest
from support.paths import ROOT
import yaml

SHOWN_BY = {
    'Odometry': {'odometry_topic'},
    'PointCloud2': {'locations_topic', 'tracks_topic'},
    'MarkerArray': {'location_markers_topic', 'markers_topic'},
    'PoseArray': {'poses_topic'},
    'PoseWithCovariance': {'target_pose_with_covariance_topic'},
    'Image': {'image_topic', 'overlay_topic'},
}
"""The parameters whose topics are of the type that a display of RViz shows."""

NAMES = ('locations', 'locations/markers', 'poses', 'target_pose_with_covariance', 'odom')
"""What the locator gives, and where the robot is."""


@pytest.fixture(scope='module')
def topics():
    """The names of the topics of all nodes, by parameter."""
    found = {}
    for table in parameter_pages.NODES.values():
        for spec in table.specs.values():
            if spec.name.endswith('_topic'):
                found.setdefault(spec.name, set()).add(f'/{spec.default}')
    return found


def test_rviz_shows_topics_that_there_are_by_displays_of_their_types(topics):
    config = yaml.safe_load((ROOT / 'rviz' / 'world.rviz').read_text())['Visualization Manager']
    shown = set()
    for display in config['Displays']:
        if 'Topic' in display:
            # relative, so that the namespace of RViz moves it as it does those of the nodes
            kind, name = display['Class'].rpartition('/')[2], f'/{display["Topic"]["Value"]}'
            assert name in set().union(*(topics[parameter] for parameter in SHOWN_BY[kind]))
            shown.add(name)
    assert shown >= {f'/{name}' for name in NAMES}
    assert config['Global Options']['Fixed Frame'] == 'odom'


def test_foxglove_shows_topics_that_there_are(topics):
    layout = json.loads((ROOT / 'foxglove' / 'world.json').read_text())
    there = set().union(*topics.values())
    panels = layout['configById']
    shown = set(panels['3D!world']['topics'])
    assert shown <= there
    assert shown >= {f'/{name}' for name in NAMES}
    for name, panel in panels.items():
        if name.startswith('Image!'):
            assert panel['imageMode']['imageTopic'] in there
    placed = json.dumps(layout['layout'])
    assert all(f'"{name}"' in placed for name in panels)
