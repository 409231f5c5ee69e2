from collections.abc import Iterator
from pathlib import Path
import signal

import pytest
from support.ros_domain import remove_orphans
from support.ros_domain import Ros


@pytest.fixture(scope='session', autouse=True)
def shared_memory() -> Iterator[None]:
    """What nodes leave that tests have killed is removed when all tests are done."""
    yield
    remove_orphans()


@pytest.fixture
def ros(tmp_path: Path) -> Iterator[Ros]:
    domain = Ros(tmp_path)
    yield domain
    domain.close()


@pytest.fixture
def replay(tmp_path, monkeypatch, capfd):
    """Runs replay in a folder of its own: exit status, what it printed, and its errors."""
    from colortrack_ros.replay.main import main

    monkeypatch.chdir(tmp_path)
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    handlers = {number: signal.getsignal(number) for number in numbers}

    def run(*arguments):
        status = main([str(argument) for argument in arguments])
        printed = capfd.readouterr()
        assert 'Traceback' not in printed.err
        return status, printed.out, printed.err

    yield run
    for number, handler in handlers.items():
        signal.signal(number, handler)


@pytest.fixture(scope='session')
def images():
    """Twelve seconds of five balls, as Image messages."""
    from support.recorded import frames
    from support.recorded import SCENE
    from support.recorded import START

    return frames(SCENE, START)


@pytest.fixture(scope='session')
def bag(images, tmp_path_factory):
    """A bag of them."""
    from support.recorded import write_bag

    return write_bag(tmp_path_factory.mktemp('in') / 'run', {'/camera/image_raw': images})
