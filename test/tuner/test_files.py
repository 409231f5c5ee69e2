"""Files and folders that are not as the tuner would like them."""

import shutil

from support.tuner import only
from support.tuner import state_of
from support.tuner import talk
from support.tuner import tuner

SCENE = 'scene:single?width=160&height=120&duration=2'


def test_a_file_that_cannot_be_changed_piece_by_piece_is_tuned_and_told_when_it_is_saved(tmp_path):
    """Its settings are not sent to other nodes that it gives them to by an alias."""
    text = '/**/detector: &d\n  ros__parameters: {min_area: 30}\n/front/detector: *d\n'
    (tmp_path / 'c.yaml').write_text(text)
    change = {'do': 'set', 'node': 'detector', 'values': {'min_area': 44}, 'follows': False}
    diff = {'do': 'diff', 'path': 'c.yaml'}
    with tuner(SCENE, '--folder', tmp_path) as url:
        answers = talk(url, [{'do': 'load', 'path': 'c.yaml'}, change, diff])
        assert only(answers, 'refused')[0]['why'].endswith('write it by hand')
        state = state_of(url)
        assert state['values']['detector']['min_area'] == 44
        assert state['unsaved']
        assert (tmp_path / 'c.yaml').read_text() == text
        assert not only(talk(url, [{'do': 'undo'}]), 'refused')[1:]
        assert not state_of(url)['unsaved']


def test_a_folder_that_is_gone_is_told_when_it_is_saved_to_and_the_page_goes_on(tmp_path, capfd):
    folder = tmp_path / 'settings'
    folder.mkdir()
    change = {'do': 'set', 'node': 'detector', 'values': {'min_area': 44}, 'follows': False}
    with tuner(SCENE, '--folder', folder) as url:
        shutil.rmtree(folder)
        assert not only(talk(url, [change]), 'refused')[1:]
        state = state_of(url)
        assert (state['values']['detector']['min_area'], state['files']) == (44, [])
        (refused, _) = only(talk(url, [{'do': 'diff', 'path': 'a.yaml'}]), 'refused')
        assert refused['why'] == f"path: expected a file in {folder}, got 'a.yaml'"
    assert capfd.readouterr().err == ''
