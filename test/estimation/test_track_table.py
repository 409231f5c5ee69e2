"""The life of tracks that no tracker is needed for."""

import numpy as np
import pytest

from colortrack_ros.data import COASTING
from colortrack_ros.data import CONFIRMED
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.data import TENTATIVE
from colortrack_ros.estimation.bank import Bank
from colortrack_ros.estimation.clock import Clock
from colortrack_ros.estimation.motion import MOTION_MODELS
from colortrack_ros.estimation.track_table import TrackTable

SECOND = NANOSECONDS


def begin(table, count, stamp=0):
    bank = table.filters
    spread = np.array([0.0, 0.0, 1.0, 1.0])
    new = bank.at_rest(np.zeros((count, 2)), np.tile(np.eye(2), (count, 1, 1)), spread)
    return table.initiate(new, stamp)


@pytest.fixture
def table():
    return TrackTable(Bank(MOTION_MODELS['switched_pair']()), [('color', 'u4')])


def test_no_id_is_used_twice(table):
    begin(table, 3)
    table.keep(np.array([True, False, False]))
    begin(table, 2)
    assert table.records['track_id'].tolist() == [1, 4, 5]
    assert len(table.filters) == 3


def test_what_is_filled_in_at_initiation_is_published(table):
    begin(table, 1)
    begin(table, 2, stamp=SECOND)['color'] = [7, 8]
    rows = table.rows(3 * SECOND, *table.filters.estimate())
    assert rows['color'].tolist() == [0, 7, 8]
    assert rows['age'].tolist() == rows['time_since_update'].tolist() == [3, 2, 2]


def test_hits_confirm_a_track_and_a_frame_without_makes_it_coast(table):
    begin(table, 2)
    states = []
    for k in range(1, 4):
        if k < 3:
            table.record_hits(np.array([0]), k)
        table.update_states(k, confirm_hits=3)
        states.append(table.records['state'].tolist())
    assert states == [[TENTATIVE] * 2, [CONFIRMED, TENTATIVE], [COASTING, TENTATIVE]]


def test_a_confirmed_track_stays_so_when_more_hits_are_asked_for(table):
    begin(table, 1)
    table.update_states(0, confirm_hits=1)
    table.update_states(0, confirm_hits=5)
    assert table.records['state'].tolist() == [CONFIRMED]


def test_a_track_is_overdue_after_the_limit_not_at_it(table):
    begin(table, 1)
    assert not table.is_overdue(SECOND, 1.0)
    assert table.is_overdue(SECOND + 1, 1.0)
    assert table.freshness(SECOND // 2, 1.0).tolist() == [0.5]


@pytest.mark.parametrize('stamp', [9 * SECOND, 13 * SECOND])
def test_the_clock_resets_its_tracker_and_tells_why_once(stamp):
    clock, reasons = Clock(), []

    def reset(why):
        reasons.append(why)
        clock.restart(why)

    assert clock.advance(10 * SECOND, 2.0, reset) == 0
    assert clock.advance(stamp, 2.0, reset) == 0
    assert clock.now == stamp
    assert len(reasons) == 1
    assert clock.tell_restart() == reasons[0] != ''
    assert clock.tell_restart() == ''
