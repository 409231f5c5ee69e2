"""batch: the same work on many recordings, on this machine or on a cluster."""

from colortrack_ros.batch.command_line import add_batch_options
from colortrack_ros.batch.command_line import FilesParser
from colortrack_ros.batch.command_line import workers_of
from colortrack_ros.batch.local import run_here
from colortrack_ros.batch.local import run_local
from colortrack_ros.batch.run import run_batch
from colortrack_ros.batch.tasks import BatchError
from colortrack_ros.batch.tasks import key_of
from colortrack_ros.batch.tasks import Outcome
from colortrack_ros.batch.tasks import Task
from colortrack_ros.batch.tasks import TaskError

__all__ = [
    'BatchError',
    'FilesParser',
    'Outcome',
    'Task',
    'TaskError',
    'add_batch_options',
    'key_of',
    'run_batch',
    'run_here',
    'run_local',
    'workers_of',
]
