"""Whose parameters a params file holds."""

from collections.abc import Iterator
from collections.abc import Sequence
import difflib
import re
from typing import Any

import yaml

from colortrack_ros.parameters.params_file import PARAMETERS

LOADER: Any = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)
"""LibYAML's, where PyYAML has it: each node reads its file as it starts, and without it a file of
1 MB takes 7 s."""

NEAR_NAMES = 0.7
"""Least similarity (difflib's ratio) of a name to the one that it may be a misspelling of: that of
detector_node and detector is 0.76, of two kinds of nodes at most 0.67."""


def owners_in(text: str | bytes) -> list[str]:
    """The full names of the nodes in a params file, with their wildcards.

    :raises ValueError: it has no nodes, which rcl would accept as a file without parameters.
    """

    def walk(name: str, tree: yaml.Node | None) -> Iterator[str]:
        for key, content in tree.value if isinstance(tree, yaml.MappingNode) else ():
            if key.value == PARAMETERS:
                yield name
            else:
                yield from walk(f'{name}/{key.value.strip("/")}', content)

    root = yaml.compose(text, Loader=LOADER)
    if not isinstance(root, yaml.MappingNode):
        raise ValueError(f'expected node names and their {PARAMETERS}')
    return list(walk('', root))


def is_owner(owner: str, node: str) -> bool:
    """Whether the node of this full name takes an owner's parameters, as rcl matches them.

    :param owner: with wildcards: ``*`` for one part of a name, ``**`` for any number of them.
    """
    parts = owner.strip('/').split('/')
    pattern = ''.join(
        r'(/[^/]+)*' if part == '**' else '/' + re.escape(part).replace(r'\*', '[^/]*')
        for part in parts
    )
    return re.fullmatch(pattern, node) is not None


def untaken(owners: Sequence[str], node: str) -> str:
    """What a params file has that may be meant for the node of this full name, which takes none of
    it: what names it in another namespace, or else by nearly its name; empty if there is nothing.
    """
    name = node.rpartition('/')[2]
    named = [owner for owner in owners if owner.rpartition('/')[2] == name]
    if not named:
        return misspelled(owners, node)
    if any(is_owner(owner, node) for owner in named):
        return ''
    how = f'under /**/{name} they are for any namespace'
    return f'has parameters for {", ".join(named)}, but none by the name {node}; {how}'


def misspelled(owners: Sequence[str], node: str) -> str:
    """What a params file has for nodes that are nearly called like this one, whose name it has
    nowhere; empty if there is nothing.
    """
    name = node.rpartition('/')[2]
    given = {owner: owner.rpartition('/')[2] for owner in owners}
    near = [owner for owner, other in given.items() if _is_misspelled(other, name)]
    if not near or name in given.values():
        return ''
    return f'has parameters for {", ".join(near)}, but none by the name {node}: is that misspelled?'


def _is_misspelled(given: str, name: str) -> bool:
    """Whether a name may be a misspelling of another; one with another number is not, nor is that
    of another kind, as line_detector is of a detector.
    """
    first, second = (re.sub(r'_?\d', '', text) for text in (given, name))
    if '*' in given or first == second or first.endswith(f'_{second}'):
        return False
    return difflib.SequenceMatcher(None, first, second).ratio() >= NEAR_NAMES
