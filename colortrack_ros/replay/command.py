"""Carries out the command line of ``replay``: one recording, or many."""

import argparse
from collections.abc import Sequence
import sys
import threading

from colortrack_ros.batch import BatchError
from colortrack_ros.replay.inputs import recordings_in
from colortrack_ros.replay.many import FAILURES
from colortrack_ros.replay.many import own_options
from colortrack_ros.replay.many import reason_of
from colortrack_ros.replay.many import replay_many
from colortrack_ros.replay.ros_arguments import misspelled_in
from colortrack_ros.replay.run import replay_recording
from colortrack_ros.replay.run import summary
from colortrack_ros.replay.setup import parse


def replay(args: Sequence[str], stop: threading.Event) -> int:
    """Carry out the command line.

    :param stop: once set, replay ends early, with complete files.
    :return: the exit status.
    """
    arguments = parse(args)
    try:
        for line in misspelled_in(arguments.params_file, ('detector', arguments.tracker)):
            print(f'replay: {line}', file=sys.stderr)
        inputs = recordings_in(arguments.inputs)
        together = arguments.report or arguments.scheduler
        if inputs != arguments.inputs or len(inputs) > 1 or together:
            return replay_many(arguments, inputs, stop)
        given = vars(arguments)
        _, own = own_options(given, inputs[0])
        return _replay_one(argparse.Namespace(**{**given, **own}), stop)
    except (*FAILURES, BatchError) as error:
        print(f'replay: {reason_of(error)}', file=sys.stderr)
        return 1


def _replay_one(arguments: argparse.Namespace, stop: threading.Event) -> int:
    result = replay_recording(arguments, stop)
    print(summary(result))
    if result.error:
        print(f'replay: {result.error}', file=sys.stderr)
        return 1
    if result.differences:
        print(f'the tracks are not those of {arguments.expect}:\n{result.differences}')
    return 0 if stop.is_set() or (result.answers.frames and not result.differences) else 1
