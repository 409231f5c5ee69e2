"""What a robot has is what rosdep gives it: tests that need more are left out there, and say so."""

import importlib.util
import os
from pathlib import Path
import signal

# before NumPy is there: the tests run side by side, and waiting threads of BLAS burn the processor
os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
# and what is started in another folder finds the same package
if PATHS := [path for path in os.environ.get('PYTHONPATH', '').split(os.pathsep) if path]:
    os.environ['PYTHONPATH'] = os.pathsep.join(map(os.path.abspath, PATHS))

from hypothesis import HealthCheck
from hypothesis import settings
import pytest

# The same examples in every run, however busy the machine: --hypothesis-profile=default looks for
# new ones.
settings.register_profile(
    'same', derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile('same')

NEEDS = {
    'rosbags': ('support.recorded', 'colortrack_ros.bags', 'colortrack_ros.replay', 'rosbags'),
    'motmetrics': ('motmetrics',),
    'playwright': ('playwright',),
}
"""Modules that no rosdep key gives, and what cannot be imported without them."""

COLCON_NODES = ('test_simulator.py', 'test_start_and_end.py', 'test_tracker.py')
"""What `colcon test`, which gives reports a prefix, runs of the nodes: three minutes in all."""

MOST_RERUNS = 3
"""Tests of real processes that get a second run: where more fail, no busy machine is to blame."""

MISSING = [name for name in NEEDS if importlib.util.find_spec(name) is None]


@pytest.hookimpl(tryfirst=True)
def pytest_cmdline_main(config: pytest.Config) -> None:
    """Under `colcon test` as many tests at once as there are processors, where xdist is there."""
    alone = config.getoption('numprocesses', '') is None and not hasattr(config, 'workerinput')
    if config.getoption('junitprefix') and alone:
        config.option.numprocesses = 'auto'


def pytest_configure(config: pytest.Config) -> None:
    """Let what tests start be ended by SIGHUP, also where the tests themselves run under nohup."""
    if signal.getsignal(signal.SIGHUP) == signal.SIG_IGN:
        signal.signal(signal.SIGHUP, signal.SIG_DFL)
    if config.pluginmanager.hasplugin('rerunfailures'):
        config.option.max_suite_reruns = MOST_RERUNS
        config.option.rerun_show_tracebacks = True


def needs_of(path: Path) -> list[str]:
    """The missing modules that a file of tests needs."""
    text = path.read_text()
    return [
        name
        for name in MISSING
        if any(f'from {module}' in text or f'import {module}' in text for module in NEEDS[name])
    ]


class Skipped(pytest.Module):
    """A file of tests that is skipped as a whole."""

    def collect(self):
        pytest.skip(f'needs {", ".join(needs_of(self.path))}, which no rosdep key gives')


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """`-m alone` imports only what has such tests: the rest takes 5 s."""
    only = config.option.markexpr == 'alone' and collection_path.name.startswith('test_')
    return True if only and 'alone' not in collection_path.read_text() else None


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Put tests of nodes, which mostly wait, between those that calculate; first what takes long.

    Tests of nodes that fail are run once more, where pytest-rerunfailures is there, and told.
    """
    items[:] = mixed(items)
    for item in items:
        if is_of_nodes(item.nodeid) and config.pluginmanager.hasplugin('rerunfailures'):
            item.add_marker(pytest.mark.flaky(reruns=1))
        if not config.getoption('junitprefix'):
            continue
        if item.get_closest_marker('slow') or item.get_closest_marker('alone'):
            item.add_marker(pytest.mark.skip('takes long: `make test` runs it'))
        elif is_of_nodes(item.nodeid) and item.path.name not in COLCON_NODES:
            item.add_marker(pytest.mark.skip('more nodes: `make test` runs it'))


def is_of_nodes(nodeid: str) -> bool:
    """Whether a test starts nodes."""
    return '/ros/' in nodeid.partition('::')[0]


def scope_of(nodeid: str) -> str:
    """What one process has to run together: files share what they have rendered, nodes do not."""
    file = nodeid.partition('::')[0]
    return nodeid if is_of_nodes(nodeid) and 'message_faults' not in file else file


def mixed(items: list[pytest.Item]) -> list[pytest.Item]:
    """The same, scope by scope: at each moment as much is over of the nodes as of the rest."""
    scopes: dict[str, list[pytest.Item]] = {}
    for item in items:
        scopes.setdefault(scope_of(item.nodeid), []).append(item)
    place = {}
    for of_nodes in (False, True):
        kind = [key for key in scopes if is_of_nodes(key) == of_nodes]
        kind.sort(key=lambda key: -sum(bool(i.get_closest_marker('slow')) for i in scopes[key]))
        place |= {key: k / len(kind) for k, key in enumerate(kind)}
    return [item for key in sorted(scopes, key=place.__getitem__) for item in scopes[key]]


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> object:
    """Hand out tests of nodes one by one, others by file: they share what the file has rendered."""
    from xdist.scheduler import LoadScopeScheduling

    class ByScope(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return scope_of(nodeid)

    config.option.loadscopereorder = False
    return ByScope(config, log)


def pytest_pycollect_makemodule(module_path: Path, parent):
    if needs_of(module_path):
        return Skipped.from_parent(parent, path=module_path)
    return None
