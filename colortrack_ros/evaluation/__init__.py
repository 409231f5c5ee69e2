"""evaluation: measures of tracks, against ground truth or without it."""

from colortrack_ros.evaluation.comparison import compare
from colortrack_ros.evaluation.comparison import Comparison
from colortrack_ros.evaluation.correspondence import Score
from colortrack_ros.evaluation.correspondence import score
from colortrack_ros.evaluation.correspondence import Tally
from colortrack_ros.evaluation.record import Record
from colortrack_ros.evaluation.record import record_of_scene
from colortrack_ros.evaluation.statistics import conditions
from colortrack_ros.evaluation.statistics import statistics
from colortrack_ros.evaluation.tables import read_record
from colortrack_ros.evaluation.tables import RecordError

__all__ = [
    'Comparison',
    'Record',
    'RecordError',
    'Score',
    'Tally',
    'compare',
    'conditions',
    'read_record',
    'record_of_scene',
    'score',
    'statistics',
]
