"""Boxes are compared where they lie, which is not around the position of what is not symmetric."""

import numpy as np
import pytest

from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import TRACK
from colortrack_ros.data import Tracks
from colortrack_ros.evaluation import compare
from colortrack_ros.evaluation import read_record
from colortrack_ros.evaluation import Record
from colortrack_ros.evaluation.record import empty_rows
from colortrack_ros.evaluation.record import rows_of_tracks
from colortrack_ros.replay.outputs import COLUMNS


def test_boxes_are_compared_where_they_lie_not_around_the_positions():
    rows, truth = np.zeros(1, TRACK), empty_rows(1)
    for name, value in (('u', 30), ('v', 12), ('box_w', 20), ('box_h', 20)):
        rows[name] = value
    rows['track_id'], rows['state'], rows['box_u'], rows['box_v'] = 1, CONFIRMED, 20.5, 20.5
    for name, value in (('id', 1), ('u', 30), ('v', 30), ('w', 20), ('h', 20), ('frame', 0)):
        truth[name] = value
    objects, found = Record.of(truth), Record.of(rows_of_tracks(Tracks(rows), 0))
    assert compare(objects, found, iou=0.9).measures['recall'] == 1
    assert compare(objects, found, radius=10.0).measures['recall'] == 0


@pytest.mark.parametrize(
    ('names', 'middle'), [(COLUMNS, (30, 20.5)), (COLUMNS[:-2], (np.nan, np.nan))]
)
def test_a_table_of_replay_says_where_boxes_lie_unless_it_is_of_before(tmp_path, names, middle):
    values = dict.fromkeys(COLUMNS, 0.0)
    values |= {'frame': 1, 'state': 1, 'u': 30, 'v': 12, 'box_w': 20, 'box_u': 20.5, 'box_v': 21}
    path = tmp_path / 'tracks.csv'
    path.write_text('\n'.join([','.join(names), ','.join(str(values[name]) for name in names), '']))
    (row,) = read_record(path).rows
    assert (row['u'], row['v']) == (30, 12)
    np.testing.assert_array_equal(row['middle'], middle)
