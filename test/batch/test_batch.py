"""Batches: whatever dies or is stopped, every task ends up with its outcome, and is done once."""

from functools import partial
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
import threading

import pytest
from support import work
from support.open_files import nothing_left_open
from support.paths import ROOT
from support.waiting import wait_until

from colortrack_ros.batch import BatchError
from colortrack_ros.batch import run_batch
from colortrack_ros.batch import Task
from colortrack_ros.batch.cluster import run_on_cluster
from colortrack_ros.batch.local import run_local

TWO = partial(run_local, jobs=2)


def tasks(folder, numbers, **given):
    return [Task(f'task {n}', f'key-{n}', {'folder': folder, 'n': n, **given}) for n in numbers]


def run(what, todo, workers=TWO, stop=None, **options):
    return run_batch(what, todo, workers, stop or threading.Event(), **options)


def nobody(what, todo, stop):
    raise AssertionError(f'nothing should be left to do, got {todo}')


def test_each_task_has_its_outcome_and_a_failure_is_its_own(tmp_path):
    outcomes = run(work.square, tasks(tmp_path, [1, 0, 2, -3]))
    assert [o.task.name for o in outcomes] == ['task 1', 'task 0', 'task 2', 'task -3']
    assert [o.result and o.result['square'] for o in outcomes] == [1, None, 4, None]
    assert [o.error for o in outcomes][::2] == ['', '']
    assert outcomes[1].error.startswith('ZeroDivisionError: ')
    assert outcomes[3].error == 'expected a positive number'


def test_a_process_that_dies_loses_nothing(tmp_path):
    often = tasks(tmp_path, [3], deaths=9)
    once = tasks(tmp_path, [1, 2], deaths=1)
    outcomes = run(work.die, [*often, *once])
    assert [o.result for o in outcomes] == [None, {'n': 1}, {'n': 2}]
    assert outcomes[0].error == 'ended 3 processes, the last with status -9'
    assert (tmp_path / 'attempts-3').read_text() == '...'


def test_a_run_that_was_stopped_goes_on_where_it_was(tmp_path):
    report = tmp_path / 'report.jsonl'
    todo, stop = tasks(tmp_path, range(1, 7)), threading.Event()

    def stopped_after_three(what, some, stop):
        for number, outcome in enumerate(TWO(what, some, stop), 1):
            if number == 3:
                stop.set()
            yield outcome

    first = run(work.square, todo, stopped_after_three, stop, report=report)
    assert 3 <= len(first) < 6
    again = run(work.square, todo, report=report)
    assert [o.result['square'] for o in again] == [1, 4, 9, 16, 25, 36]
    lines = [json.loads(line) for line in report.read_text().splitlines()]
    assert [line['name'] for line in lines] == [task.name for task in todo]
    assert all(line['result'] and line['error'] == '' for line in lines)
    assert run(work.square, todo, nobody, report=report) == again
    done = (tmp_path / 'done').read_text().split()
    assert {done.count(str(o.task.given['n'])) for o in first} == {1}
    assert len(run(work.square, todo, report=report, fresh=True)) == 6


def test_what_failed_is_tried_again_and_what_may_not_begin_is_told(tmp_path):
    report = tmp_path / 'report.jsonl'
    todo = tasks(tmp_path, [1, -2])

    def refuse(task):
        return 'is there already' if task.given['n'] == 1 else ''

    first = run(work.square, todo, report=report, refuse=refuse)
    assert [o.error for o in first] == ['is there already', 'expected a positive number']
    run(work.square, todo, report=report)
    assert sorted((tmp_path / 'done').read_text().split()) == ['-2', '-2', '1']


def test_what_a_killed_run_has_begun_is_not_refused_by_its_own_traces(tmp_path):
    report = tmp_path / 'report.jsonl'
    todo = tasks(tmp_path, [1, 2])
    report.write_text('{"name": "task 1", "key": "key-1"}\n{"name": "task 2", "ke')
    outcomes = run(work.square, todo, report=report, refuse=lambda _: 'is there already')
    assert [o.error for o in outcomes] == ['', 'is there already']


@pytest.mark.parametrize('text', ['frame,id\n1,2\n', '[]', '{"measures": 1}', '\0'])
def test_a_file_that_is_no_report_is_left_alone(tmp_path, text):
    report = tmp_path / 'tracks.csv'
    report.write_text(text)
    said = 'expected the report of an earlier run'
    with nothing_left_open(), pytest.raises(BatchError, match=said):
        run(work.square, tasks(tmp_path, [1]), nobody, report=report)
    assert report.read_text() == text


def test_a_report_has_one_writer_and_a_folder(tmp_path):
    report = tmp_path / 'report.jsonl'

    def meanwhile(what, todo, stop):
        with pytest.raises(BatchError, match='another run writes it now'):
            run(what, todo, nobody, report=report)
        return iter(())

    run(work.square, tasks(tmp_path, [1]), meanwhile, report=report)
    with pytest.raises(BatchError, match='No such file'):
        run(work.square, tasks(tmp_path, [1]), nobody, report=tmp_path / 'none' / 'x')


BATCH = """
import sys, threading
from pathlib import Path
from test_batch import TWO, tasks, work, run
if __name__ == '__main__':
    folder = Path(sys.argv[1])
    run(work.wait, tasks(folder, [1, 2, 3]), report=folder / 'report.jsonl')
"""


def test_nothing_outlives_a_run_that_is_killed(tmp_path):
    script = tmp_path / 'script.py'
    script.write_text(BATCH)
    paths = os.pathsep.join(map(str, (ROOT / 'test', Path(__file__).parent, ROOT)))
    killed = subprocess.Popen(
        [sys.executable, str(script), str(tmp_path)], env={**os.environ, 'PYTHONPATH': paths}
    )
    try:
        wait_until(lambda: len(work.pids(tmp_path)) == 2)
    finally:
        killed.kill()
        killed.wait()
    wait_until(lambda: not any(map(work.is_alive, work.pids(tmp_path))))
    assert len(list(tmp_path.glob('stopped-*'))) == 2
    (tmp_path / 'go').touch()
    again = run(work.wait, tasks(tmp_path, [1, 2, 3]), report=tmp_path / 'report.jsonl')
    assert [o.result for o in again] == [{'n': 1}, {'n': 2}, {'n': 3}]


@pytest.mark.slow
def test_a_cluster_of_two_workers_of_which_one_is_killed_does_all(tmp_path):
    distributed = pytest.importorskip('distributed', reason='needs Dask: the extra `cluster`')
    options = {'threads_per_worker': 1, 'dashboard_address': None, 'host': '127.0.0.1'}
    with distributed.LocalCluster(n_workers=2, processes=True, **options) as cluster:
        outcomes = []
        workers = partial(run_on_cluster, scheduler=cluster.scheduler_address)
        todo = tasks(tmp_path, range(4))
        thread = threading.Thread(
            target=lambda: outcomes.extend(run(work.wait, todo, workers)), daemon=True
        )
        thread.start()
        wait_until(lambda: len(work.pids(tmp_path)) == 2)
        victim = min(work.pids(tmp_path))
        os.kill(victim, signal.SIGKILL)
        wait_until(lambda: not work.is_alive(victim))
        (tmp_path / 'go').touch()
        thread.join(120.0)
    assert [o.result for o in outcomes] == [{'n': n} for n in range(4)]
    assert {o.error for o in outcomes} == {''}


@pytest.mark.slow
def test_a_scheduler_that_does_not_answer_is_told(tmp_path):
    dask = pytest.importorskip('dask', reason='needs Dask: the extra `cluster`')
    workers = partial(run_on_cluster, scheduler='tcp://127.0.0.1:1')
    with (
        dask.config.set({'distributed.comm.timeouts.connect': '0.2s'}),
        pytest.raises(BatchError, match=r'tcp://127.0.0.1:1: does not answer'),
    ):
        run(work.square, tasks(tmp_path, [1]), workers)
