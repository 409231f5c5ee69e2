"""Interlaced films: of camcorders, television, DVDs."""

import base64

import cv2
import numpy as np
import pytest

from colortrack_ros.sources import open_source
from colortrack_ros.sources import SourceError

pytestmark = pytest.mark.slow

FILM = base64.b64decode(
    'AAABswIAIBP//+AYAAABtRSCAAEAAAAAAbgACABAAAABAAAP//gAAAG1j//zgAAAAAEB+3kKUpfM37haUpSIgAAAAQL7'
    'eQpSl8zfuFpSlIiAAAABswIAIBP//+AYAAABtRSCAAEAAAAAAbgACADAAAABAAAP//gAAAG1j//zgAAAAAEB+3kKUpfj'
    'V97aUpSIgAAAAQL7eQpSl+NX3tpSlIiAAAABswIAIBP//+AYAAABtRSCAAEAAAAAAbgACAFAAAABAAAP//gAAAG1j//z'
    'gAAAAAEB+3kKUpfhV5tpSlIiAAAABAvt5ClKX4VebaUpSIgAAAAbMCACAT///gGAAAAbUUggABAAAAAAG4AAgBwAAAAQ'
    'AAD//4AAABtY//84AAAAABAft5ClKX5jfk1pSlIiAAAAEC+3kKUpfmN+TWlKUiIA=='
)
"""Four pictures of MPEG-2, 32x32, each of another color, the first red."""

START, CODING, PROGRESSIVE = b'\0\0\1\xb3', b'\0\0\1\xb5\x8f', 0x80
"""Codes before a picture and before its coding, and the bit that marks it as whole, 8 bytes on."""


def pictures_or_error(path):
    try:
        return [frame.image for frame in open_source(path)], ''
    except SourceError as error:
        return [], str(error)


def first(count):
    """The first pictures of the film."""
    return START.join(FILM.split(START)[: count + 1])


def first_is_whole():
    """The film, of which all pictures but the first are interlaced."""
    film = bytearray(FILM)
    film[film.index(CODING) + 8] |= PROGRESSIVE
    return bytes(film)


@pytest.mark.parametrize(
    ('film', 'count'),
    [(first(1), 1), (first(2), 2), (FILM, 4), (first_is_whole(), 4)],
    ids=['one', 'two', 'four', 'first_is_whole'],
)
def test_an_interlaced_film_is_read_or_refused_with_what_to_do_but_is_no_random_memory(
    tmp_path, film, count
):
    path = tmp_path / 'film.m2v'
    path.write_bytes(film)
    pictures, error = pictures_or_error(path)
    if error:
        assert 'interlaced' in error
        assert 'yadif' in error
    else:
        colors = {tuple(np.round(picture.mean(axis=(0, 1)), -1)) for picture in pictures}
        assert len(colors) == len(pictures) == count
        assert pictures[0][..., 2].min() > 200, 'the first is red'


def test_a_film_in_which_nothing_changes_is_no_interlaced_one(tmp_path, monkeypatch):
    """Nor does it matter what else is in its folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'cv2.py').write_text('print("interlaced")')
    path = tmp_path / 'film.avi'
    film = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*'MJPG'), 25, (32, 32))
    for _ in range(5):
        film.write(np.full((32, 32, 3), 90, np.uint8))
    film.release()
    pictures, error = pictures_or_error(path)
    assert not error
    assert len(pictures) == 5
