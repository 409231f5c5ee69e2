"""What the tuner says when it cannot start."""

import pytest

from colortrack_ros.tuner.main import main

SCENE = 'scene:single?width=160&height=120&duration=2'


@pytest.mark.slow
@pytest.mark.parametrize(
    ('arguments', 'reason'),
    [
        (['nothing.mp4'], 'there is no such file'),
        (['scene:nothing'], 'nothing'),
        ([SCENE, '--folder', '/nowhere'], 'expected a folder'),
        ([SCENE, '--params-file', 'setup.py'], 'expected a name that ends in'),
    ],
)
def test_a_start_that_cannot_be_says_why_in_a_line(arguments, reason, capfd):
    assert main([*arguments, '--port', '0']) == 1
    said = capfd.readouterr().err
    assert reason in said
    assert said.startswith('tuner: ')
    assert len(said.splitlines()) == 1
