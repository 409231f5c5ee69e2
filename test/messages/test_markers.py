from dataclasses import replace

import numpy as np
import pytest
from rclpy.serialization import deserialize_message
from rclpy.serialization import serialize_message
from visualization_msgs.msg import Marker
from visualization_msgs.msg import MarkerArray

from colortrack_ros.bags import canonical
from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import TENTATIVE
from colortrack_ros.data import TRACK
from colortrack_ros.data import Tracks
from colortrack_ros.messages import MarkerWriter


def tracks(*ids, state=CONFIRMED, restarted=''):
    rows = np.zeros(len(ids), TRACK)
    rows['track_id'], rows['state'], rows['box_h'] = ids, state, 10
    rows['u'], rows['v'], rows['du'] = 30, 40, 100
    rows['covariance'] = np.diag([4.0, 9.0, 1.0, 1.0])
    return Tracks(rows, 5, 'cam', restarted)


def begun():
    """A writer that has written its first message, which deletes all."""
    writer = MarkerWriter()
    assert [m.action for m in written(writer, tracks(), 1.0)] == [Marker.DELETEALL]
    return writer


def written(writer, some, scale):
    return deserialize_message(writer.write(some, scale), MarkerArray).markers


def test_the_first_message_deletes_what_a_tracker_that_was_killed_has_left():
    writer = MarkerWriter()
    actions = [m.action for m in written(writer, tracks(1), 1.0)]
    assert actions == [Marker.DELETEALL] + 3 * [Marker.ADD]
    assert [m.action for m in written(writer, tracks(1), 1.0)] == 3 * [Marker.ADD]


def test_three_markers_for_a_track_in_metres():
    ellipse, arrow, text = written(begun(), tracks(7), 0.1)
    assert {m.id for m in (ellipse, arrow, text)} == {7}
    assert (ellipse.header.stamp.nanosec, ellipse.header.frame_id) == (5, 'cam')
    assert np.allclose((ellipse.pose.position.x, ellipse.pose.position.y), (3, 4))
    # two sigma: full axes of four standard deviations, the longer one along v
    assert np.allclose((ellipse.scale.x, ellipse.scale.y), (4 * 3 * 0.1, 4 * 2 * 0.1))
    angle = 2 * np.arctan2(ellipse.pose.orientation.z, ellipse.pose.orientation.w)
    assert np.isclose(abs(np.sin(angle)), 1)
    assert np.isclose(arrow.points[1].x - arrow.points[0].x, 10)
    assert text.text == '7'


def test_markers_are_as_large_as_their_track_and_green_or_amber():
    """Sizes are shares of the height of the box, here 10 px of 0.2 m."""
    ellipse, arrow, text = written(begun(), tracks(7), 0.2)
    assert np.isclose(ellipse.scale.z, 0.02)
    assert np.allclose([arrow.scale.x, arrow.scale.y, arrow.scale.z], [0.1, 0.2, 0])
    assert np.isclose(text.scale.z, 1)
    assert np.allclose([text.pose.position.x, text.pose.position.y], [6, 8 - 1.5])
    color = ellipse.color
    assert np.allclose([color.r, color.g, color.b, color.a], [0.1, 0.8, 0.2, 0.8])
    color = written(begun(), tracks(7, state=COASTING), 0.1)[0].color
    assert np.allclose([color.r, color.g, color.b, color.a], [0.9, 0.7, 0.1, 0.5])


def test_an_ellipse_lies_along_what_is_uncertain():
    some = tracks(7)
    some.rows['covariance'][:, :2, :2] = [[5.0, 4.0], [4.0, 5.0]]
    some.rows['v'], some.rows['dv'] = 40, -20
    ellipse, arrow, _ = written(begun(), some, 0.1)
    assert np.allclose((ellipse.scale.x, ellipse.scale.y), (4 * 3 * 0.1, 4 * 1 * 0.1))
    turn = ellipse.pose.orientation
    assert np.isclose(2 * np.arctan2(turn.z, turn.w), np.pi / 4)
    assert (turn.x, turn.y) == (0, 0)
    start, end = arrow.points
    assert np.allclose([start.x, start.y, end.x, end.y], [3, 4, 13, 2])


def test_ids_of_all_lengths_stand_above_their_own_tracks():
    some = tracks(9, 10, 123)
    some.rows['u'] = [30, 50, 70]
    texts = [m for m in written(begun(), some, 0.1) if m.ns == 'id']
    assert [(m.id, m.text) for m in texts] == [(9, '9'), (10, '10'), (123, '123')]
    assert np.allclose([m.pose.position.x for m in texts], [3, 5, 7])


def test_a_tentative_track_has_no_markers():
    assert written(begun(), tracks(1, state=TENTATIVE), 1.0) == []


def test_a_track_that_has_gone_is_deleted_once():
    writer = begun()
    writer.write(tracks(1, 2), 1.0)
    gone = [m for m in written(writer, tracks(2), 1.0) if m.action == Marker.DELETE]
    assert [(m.ns, m.id) for m in gone] == [('ellipse', 1), ('velocity', 1), ('id', 1)]
    assert all(m.action == Marker.ADD for m in written(writer, tracks(2), 1.0))


def test_all_markers_are_deleted_after_a_restart():
    writer = begun()
    writer.write(tracks(1, 2), 1.0)
    markers = written(writer, tracks(3, restarted='the stamp went back'), 1.0)
    assert [m.action for m in markers] == [Marker.DELETEALL] + 3 * [Marker.ADD]


def outlined(*ids, state=CONFIRMED):
    """Tracks with a triangle around each."""
    corners = np.array([(0.0, -5.0), (5.0, 5.0), (-5.0, 5.0)])
    outlines = np.stack([corners + np.array([100.0 * i, 40.0]) for i in ids]).reshape(-1, 3, 2)
    return replace(tracks(*ids, state=state), outlines=outlines)


def test_an_outline_is_a_closed_strip_and_is_deleted_with_its_track():
    writer = begun()
    strip = written(writer, outlined(1, 2), 0.1)[7]
    assert (strip.ns, strip.id, strip.type) == ('outline', 2, Marker.LINE_STRIP)
    points = [(p.x, p.y) for p in strip.points]
    np.testing.assert_allclose(points, [(20, 3.5), (20.5, 4.5), (19.5, 4.5), (20, 3.5)])
    assert strip.scale.x > 0
    gone = [m.ns for m in written(writer, outlined(2), 0.1) if m.action == Marker.DELETE]
    assert gone == ['ellipse', 'velocity', 'id', 'outline']
    gone = [m.ns for m in written(writer, tracks(), 0.1)]
    assert gone == ['ellipse', 'velocity', 'id', 'outline']
    assert written(writer, outlined(3, state=TENTATIVE), 0.1) == []


@pytest.mark.parametrize('frame_id', ['', 'c', 'cam', 'camera', 'k\u00e4mera'])
def test_it_is_what_ros_serializes_at_any_length_of_names_and_ids(frame_id):
    writer = begun()
    for ids in ([1], [9, 10, 99, 100, 12345], [7]):
        cdr = writer.write(replace(outlined(*ids), frame_id=frame_id), 0.1)
        message = deserialize_message(cdr, MarkerArray)
        assert canonical(serialize_message(message), 'visualization_msgs/msg/MarkerArray') == cdr
        assert {marker.header.frame_id for marker in message.markers} == {frame_id}
        labels = [marker.text for marker in message.markers if marker.text]
        assert labels == [str(i) for i in ids]


def test_who_comes_after_markers_that_nobody_took_begins_with_none():
    writer = begun()
    writer.write(tracks(1, 2), 1.0)
    writer.skip()
    actions = [m.action for m in written(writer, tracks(2), 1.0)]
    assert actions == [Marker.DELETEALL] + 3 * [Marker.ADD]
    assert [m.action for m in written(writer, tracks(2), 1.0)] == 3 * [Marker.ADD]
