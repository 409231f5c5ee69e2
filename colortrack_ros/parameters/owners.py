"""Whose parameters a params file holds."""

from collections.abc import Iterator
from collections.abc import Sequence
import re
from typing import Any

import yaml

from colortrack_ros.parameters.params_file import PARAMETERS

LOADER: Any = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)
"""LibYAML's, where PyYAML has it: each node reads its file as it starts, and without it a file of
1 MB takes 7 s."""


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


def of_another_namespace(owners: Sequence[str], node: str) -> list[str]:
    """The owners that a node of this full name may have been meant by: they have its last name.

    Empty if it is one of them, as of several robots in one file.
    """
    named = [owner for owner in owners if owner.rpartition('/')[2] == node.rpartition('/')[2]]
    return [] if any(is_owner(owner, node) for owner in named) else named
