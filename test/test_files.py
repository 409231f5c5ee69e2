import os
import threading

import pytest

from colortrack_ros import files
from colortrack_ros.files import read_file
from colortrack_ros.files import resolved
from colortrack_ros.files import write_file


def test_a_file_is_read_up_to_its_limit(tmp_path):
    path = tmp_path / 'ten'
    path.write_bytes(b'0123456789')
    assert read_file(path, 10) == b'0123456789'
    with pytest.raises(ValueError, match='at most 9 bytes'):
        read_file(str(path), 9)


def test_what_is_no_regular_file_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / 'pipe')
    (tmp_path / 'loop').symlink_to('loop')
    (tmp_path / 'dangling').symlink_to('nowhere')
    there = [str(tmp_path / name) for name in ('pipe', 'loop', 'dangling', 'missing', '')]
    for path in (*there, '/dev/zero', '/dev/null', '/dev/tty', 'x\0y', 'x' * 5000):
        with pytest.raises(ValueError, match=r'.') as refused:
            read_file(path, 100)
        assert 'could not be read within' not in str(refused.value)  # after a wait


def test_a_file_that_never_comes_is_not_waited_for(tmp_path, monkeypatch):
    never = threading.Event()
    monkeypatch.setattr(files, 'TIME_TO_READ', 0.1)
    monkeypatch.setattr(files, '_read', lambda *_: never.wait())
    with pytest.raises(ValueError, match=r'within 0\.1 s'):
        read_file(tmp_path, 100)
    never.set()


def test_a_file_is_written_as_a_whole_or_stays_as_it_was(tmp_path, monkeypatch):
    path, link = tmp_path / 'mine.yaml', tmp_path / 'link.yaml'
    path.write_bytes(b'old')
    path.chmod(0o600)
    link.symlink_to(path)
    write_file(link, b'new')
    assert path.read_bytes() == b'new'
    assert path.stat().st_mode & 0o777 == 0o600
    assert link.is_symlink()

    def refuse(*_):
        assert path.read_bytes() == b'new'  # until all is there
        raise OSError('no space left')

    monkeypatch.setattr(os, 'replace', refuse)
    with pytest.raises(OSError, match='no space'):
        write_file(path, b'newer')
    assert path.read_bytes() == b'new'
    assert sorted(tmp_path.iterdir()) == [link, path]


def test_a_file_that_is_read_only_is_not_replaced(tmp_path, monkeypatch):
    """Its folder would allow it, and root may write to it all the same."""
    path = tmp_path / 'mine.yaml'
    path.write_bytes(b'old')
    asked = []
    monkeypatch.setattr(os, 'access', lambda *given: asked.append(given))
    with pytest.raises(PermissionError, match=r'mine\.yaml'):
        write_file(path, b'new')
    assert asked == [(path.resolve(), os.W_OK)]
    assert path.read_bytes() == b'old'
    assert sorted(tmp_path.iterdir()) == [path]


def test_a_file_that_root_changes_stays_that_of_its_owner(tmp_path, monkeypatch):
    path = tmp_path / 'mine.yaml'
    path.write_bytes(b'old')
    path.chmod(0o640)
    given = []
    monkeypatch.setattr(os, 'chown', lambda _, *ids: given.append(ids))
    write_file(path, b'new')
    assert given == [(os.getuid(), os.getgid())]

    def refuse(*_):
        raise PermissionError

    monkeypatch.setattr(os, 'chown', refuse)
    write_file(path, b'newer')
    assert path.read_bytes() == b'newer'
    assert path.stat().st_mode & 0o777 == 0o640


def test_a_link_to_itself_is_an_error_of_the_system_with_every_python(tmp_path):
    (tmp_path / 'loop.csv').symlink_to('loop.csv')
    (tmp_path / 'link.csv').symlink_to('real.csv')
    assert resolved(tmp_path / 'link.csv') == tmp_path.resolve() / 'real.csv'
    for use in (resolved, lambda path: write_file(path, b'')):
        with pytest.raises(OSError, match='symbolic links'):
            use(tmp_path / 'loop.csv')
    assert sorted(os.listdir(tmp_path)) == ['link.csv', 'loop.csv']
