"""Records: as a structured array would be, with another layout."""

from copy import deepcopy

from hypothesis import given
from hypothesis import strategies
import numpy as np
import pytest

from colortrack_ros.estimation.records import Records

FIELDS = [('track_id', 'u4'), ('hits', 'u4'), ('seen', 'f8', 2), ('was', 'f8', (2,)), ('told', '?')]


def both(count, seed=1):
    """The same rows as Records and as a structured array."""
    rng, records, rows = (
        np.random.default_rng(seed),
        Records(FIELDS, count),
        np.zeros(count, FIELDS),
    )
    for name in rows.dtype.names:
        rows[name] = records[name] = rng.integers(0, 2 if name == 'told' else 99, rows[name].shape)
    return records, rows


def assert_alike(records, rows):
    assert len(records) == len(rows)
    assert records.names == rows.dtype.names
    for name in rows.dtype.names:
        assert records[name].dtype == rows[name].dtype
        assert records[name].flags.c_contiguous
        np.testing.assert_array_equal(records[name], rows[name])


@pytest.mark.slow
@given(strategies.lists(strategies.integers(0, 4), max_size=6), strategies.integers(0, 4))
def test_rows_are_taken_kept_and_joined_as_those_of_a_structured_array(which, count):
    records, rows = both(5)
    below, rows_below = both(count, 2)
    which = np.array(which, np.intp)
    assert_alike(records.take(which), rows[which])
    assert_alike(records.grown(count), np.concatenate([rows, np.zeros(count, FIELDS)]))
    assert_alike(records, rows)
    records.keep(which)
    assert_alike(records, rows[which])
    records.extend(below)
    assert_alike(records, np.concatenate([rows[which], rows_below]))


def test_what_is_written_to_a_field_or_to_a_part_is_in_the_table():
    records, rows = both(4)
    records['hits'] += 1
    records['seen'][1] = 7.0, 8.0
    part = records.part(slice(2, None))
    part['told'] = [True, False]
    rows['hits'] += 1
    rows['seen'][1] = 7.0, 8.0
    rows['told'][2:] = [True, False]
    assert_alike(records, rows)
    assert_alike(part, rows[2:])


def test_copies_share_nothing_with_the_table():
    records, rows = both(3)
    copies = records.copy(), deepcopy(records), records.take(np.ones(3, bool))
    records['seen'] = -1.0
    for copy in copies:
        assert_alike(copy, rows)


def test_rows_are_written_over_others():
    records, rows = both(4)
    records.put(np.array([0, 3]), records.take(np.array([3, 1])))
    rows[[0, 3]] = rows[[3, 1]]
    assert_alike(records, rows)
