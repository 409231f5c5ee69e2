"""Where streams end, written byte by byte."""

import pytest

from colortrack_ros.sources.ends import is_cut_off
from colortrack_ros.sources.ends import last_picture


@pytest.mark.parametrize(('before', 'after'), [(0, 0), (4, 0), (0, 16)])
def test_packets_of_transport_streams_are_known_with_times_and_codes_as_well(
    tmp_path, before, after
):
    path = tmp_path / 'film.ts'
    packet = bytes(before) + b'\x47' + bytes(187 + after)
    path.write_bytes(5 * packet)
    assert not is_cut_off(str(path))
    path.write_bytes(5 * packet + packet[:100])
    assert is_cut_off(str(path))
    assert last_picture(str(path)) == 0.0
