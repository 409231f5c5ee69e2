"""Reads and changes values in the text of a params file; comments, order, and all else stay.

It is a file for ``--params-file``: node names, ``ros__parameters`` below each, and values, nested
or with dotted names.
"""

from collections.abc import Iterator
from collections.abc import Mapping
import re
from typing import Any
from typing import NamedTuple

import yaml

PARAMETERS = 'ros__parameters'

ALIAS = re.compile(r'(?:^|[\s\[{,:])\*', re.MULTILINE)
"""Where a YAML alias may be: it repeats what its anchor stands before."""

Pair = tuple[yaml.Node, yaml.Node]


class Splice(NamedTuple):
    """A range of the text, and its replacement."""

    begin: int
    end: int
    text: str


def given_in(text: str, kind: str) -> dict[str, Any]:
    """The values that a params file gives to a kind of node, by full name.

    :param kind: the last part of the node's name, such as ``detector``; if the file has several
        nodes of that kind, the first counts.
    :raises ValueError: the text is not a params file.
    """
    block = _block(_composed(text), kind)
    if block is None:
        return {}
    try:
        values = yaml.SafeLoader('').construct_document(block)
    except yaml.YAMLError as error:
        raise ValueError(f'expected YAML: {" ".join(str(error).split())}') from error
    if not isinstance(values, dict):
        raise ValueError(f'{kind}: expected names and values below {PARAMETERS}')
    return dict(_flat(values))


def has_node(text: str, kind: str) -> bool:
    """Whether a params file has a node of a kind.

    :raises ValueError: the text is not a params file.
    """
    return _block(_composed(text), kind) is not None


def with_values(text: str, kind: str, values: Mapping[str, Any]) -> str:
    """The text with some values changed.

    :param kind: of the node; if the file has none, ``/**/kind`` is added.
    :param values: by full name; None removes the value from the file.
    :raises ValueError: the text is not a params file, or cannot be edited in place, for example
        because it uses anchors.
    """
    if '\r\n' in text and text.count('\r\n') == text.count('\n'):  # as editors of Windows write
        return with_values(text.replace('\r\n', '\n'), kind, values).replace('\n', '\r\n')
    expected = {**given_in(text, kind), **values}
    changed = text
    for name, value in values.items():
        splice = _splice(changed, kind, name, value)
        if splice:
            changed = changed[: splice.begin] + splice.text + changed[splice.end :]
    expected = {k: v for k, v in expected.items() if v is not None}
    try:
        is_right = given_in(changed, kind) == expected
        if ALIAS.search(text):  # otherwise nothing else can have changed
            is_right = is_right and _elsewhere(changed, kind) == _elsewhere(text, kind)
    except (ValueError, yaml.YAMLError):  # such as an alias whose anchor has gone
        is_right = False
    if not is_right:
        raise ValueError(f'{kind}: this file cannot be changed piece by piece: write it by hand')
    return changed


def _elsewhere(text: str, kind: str) -> dict[str, str]:
    """All values that are not those of :func:`given_in`."""
    tree = yaml.safe_load(text) or {}
    prefix = _prefix(tree, kind)
    return {
        name: repr(value)  # nan is not equal to itself
        for name, value in _flat(tree)
        if not prefix or not name.startswith(prefix)
    }


def _prefix(tree: Any, kind: str, name: str = '', prefix: str = '') -> str:
    """What the names of the values begin with that :func:`_block` finds; empty for none."""
    for key, value in tree.items() if isinstance(tree, dict) else ():
        inner = f'{prefix}{key}.'
        if key == PARAMETERS and name.rpartition('/')[2] == kind:
            return inner
        if found := _prefix(value, kind, f'{name}/{key}', inner):
            return found
    return ''


def flow(value: Any) -> str:
    """A value as YAML on one line."""
    text = yaml.safe_dump(
        value, default_flow_style=True, sort_keys=False, width=1 << 20, allow_unicode=True
    )
    return text.removesuffix('...\n').strip()


def quoted(text: str) -> str:
    """A name as YAML, in quotes if needed."""
    return flow([text])[1:-1]


def _composed(text: str) -> Any:
    try:
        root: Any = yaml.compose(text, yaml.SafeLoader)
    except yaml.YAMLError as error:
        raise ValueError(f'expected YAML: {" ".join(str(error).split())}') from error
    if root is not None and not isinstance(root, yaml.MappingNode):
        raise ValueError(f'expected names of nodes, and {PARAMETERS} below each')
    return root


def _flat(tree: Mapping[Any, Any], prefix: str = '') -> Iterator[tuple[str, Any]]:
    for key, value in tree.items():
        if isinstance(value, dict):
            yield from _flat(value, f'{prefix}{key}.')
        else:
            yield f'{prefix}{key}', value


def _block(node: Any, kind: str, name: str = '') -> Any:
    """The parameters of the first node of a kind; None if there is none."""
    if not isinstance(node, yaml.MappingNode):
        return None
    for key, value in node.value:
        if key.value == PARAMETERS and name.rpartition('/')[2] == kind:
            return value
        found = _block(value, kind, f'{name}/{key.value}')
        if found is not None:
            return found
    return None


def _splice(text: str, kind: str, name: str, value: Any) -> Splice | None:
    root = _composed(text)
    block = _block(root, kind)
    if block is None:
        return None if value is None else _new_node(text, root, kind, name, value)
    parents, rest = _reach(block, name)
    mapping, pair = parents[-1]
    if rest == '' and pair:
        return _removal(text, parents) if value is None else _replacement(text, pair, flow(value))
    if value is None:
        return None
    for part in reversed(rest.split('.')[1:]):
        value = {part: value}
    if pair:  # there is a value where a mapping is needed
        return _replacement(text, pair, flow({rest.split('.')[0]: value}))
    return _addition(text, mapping, {rest.split('.')[0]: value})


def _reach(block: Any, name: str) -> tuple[list[tuple[Any, Pair | None]], str]:
    """The mappings on the path to a name, with the entry chosen in each, and the rest of the
    name.
    """
    way: list[tuple[Any, Pair | None]] = []
    while isinstance(block, yaml.MappingNode):
        pairs = {str(key.value): (key, value) for key, value in block.value}
        first, _, rest = name.partition('.')
        key = name if name in pairs else first
        way.append((block, pairs.get(key)))
        if key == name or key not in pairs:
            return way, '' if key in pairs else name
        block, name = pairs[key][1], rest
    if not way:
        raise ValueError(f'expected names and values below {PARAMETERS}')
    return way, name


def _new_node(text: str, root: Any, kind: str, name: str, value: Any) -> Splice:
    for part in reversed(name.split('.')):
        value = {part: value}
    if root is not None and root.flow_style:
        return _addition(text, root, {f'/**/{kind}': {PARAMETERS: value}})
    ((first, content),) = value.items()
    line = f'/**/{kind}:\n  {PARAMETERS}:\n    {quoted(first)}: {flow(content)}\n'
    gap = '' if not text.strip() else '\n' if text.endswith('\n') else '\n\n'
    return Splice(len(text), len(text), gap + line)


def _addition(text: str, mapping: Any, entries: Mapping[str, Any]) -> Splice:
    added = ', '.join(f'{quoted(key)}: {flow(value)}' for key, value in entries.items())
    end = _end(mapping)
    if mapping.flow_style:
        return Splice(end - 1, end - 1, (', ' if mapping.value else '') + added)
    # After the comment at the end of the last line.
    end = (text + '\n').index('\n', end)
    return Splice(end, end, '\n' + ' ' * mapping.start_mark.column + added)


def _replacement(text: str, pair: Pair, new: str) -> Splice:
    """Put a value on the line of its key, before a comment."""
    key, value = pair
    begin, start = key.end_mark.index, value.start_mark.index
    between = text[begin:start]
    if '\n' not in between and start > begin + 1:
        return Splice(start, _end(value), new)
    return Splice(begin, max(_end(value), begin + 1), f': {new}{between[1:].rstrip()}')


def _removal(text: str, parents: list[tuple[Any, Any]]) -> Splice:
    """Remove the last entry, and mappings that hold nothing else."""
    while len(parents) > 1 and len(parents[-1][0].value) == 1:
        parents = parents[:-1]
    mapping, pair = parents[-1]
    if len(mapping.value) == 1:
        begin, end = mapping.start_mark.index, _end(mapping)
        return Splice(begin, end, '{}')
    k = mapping.value.index(pair)
    if mapping.flow_style:
        if k:
            return Splice(_end(mapping.value[k - 1][1]), _end(pair[1]), '')
        return Splice(pair[0].start_mark.index, mapping.value[1][0].start_mark.index, '')
    if k == 0:  # the mapping begins here
        return Splice(pair[0].start_mark.index, mapping.value[1][0].start_mark.index, '')
    begin = text.rindex('\n', 0, pair[0].start_mark.index)
    return Splice(begin, (text + '\n').index('\n', _end(pair[1])), '')


def _end(node: Any) -> int:
    """The end of a node, without the comments after it, which YAML includes in the block."""
    if isinstance(node, yaml.ScalarNode) or node.flow_style or not node.value:
        return int(node.end_mark.index)
    last = node.value[-1]
    return _end(last[1] if isinstance(last, tuple) else last)
