import pytest

from colortrack_ros.flow.faults import fault_of
from colortrack_ros.parameters import params_file


def fault(call, *arguments):
    try:
        call(*arguments)
    except Exception as error:
        return fault_of(error)
    raise AssertionError('it does not fail')


def test_the_place_is_ours_where_a_library_raises_for_what_we_gave_it():
    text = fault(params_file.flow, object())
    assert text.startswith('a fault of ours at params_file.py:'), text
    assert 'please report it: RepresenterError' in text


def test_it_is_in_one_line_also_where_a_library_fails_alone():
    with pytest.raises(SyntaxError) as caught:
        compile('1\n2 +', 'a\nb', 'exec')
    assert '\n' not in fault_of(caught.value)
