"""The parameters of nodes in YAML files, without a node: what rcl makes of the same files."""

from collections.abc import Iterable
from collections.abc import Iterator
from pathlib import Path
import re
from typing import Any
from typing import NamedTuple

import yaml

_TRUE = re.compile('y|Y|yes|Yes|YES|true|True|TRUE|on|On|ON')
_FALSE = re.compile('n|N|no|No|NO|false|False|FALSE|off|Off|OFF')
_INT = re.compile('[-+]?(0[xX][0-9a-fA-F]+|0[0-7]*|[1-9][0-9]*)')
_FLOAT = re.compile(r'[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?|[-+]?\.?(inf|Inf|INF|nan|NaN|NAN)')


class Given(NamedTuple):
    """A value that somebody gives to a parameter.

    :param nodes: whose it is: a full node name in which ``*`` stands for one token and ``**`` for
        any number of them.
    :param name: of the parameter.
    :param value: in the type that its YAML has.
    """

    nodes: str
    name: str
    value: Any

    def is_for(self, node: str) -> bool:
        """Whether the node, a full name such as ``/robot1/detector``, takes the value."""
        wild = {'/**': '(/[^/]+)*', '/*': '/[^/]+'}
        tokens = re.findall('/[^/]+', self.nodes)
        pattern = ''.join(wild.get(token, re.escape(token)) for token in tokens)
        return re.fullmatch(pattern, node) is not None

    @property
    def is_for_any(self) -> bool:
        """Whether nodes of any name may take it."""
        return self.nodes.endswith('*')


def read_params_file(path: Path) -> list[Given]:
    """All values in a file, in their order: a later one replaces an earlier one.

    :raises ValueError: the file cannot be read, or is not a file of parameters.
    """
    try:
        root = yaml.compose(path.read_text(), Loader=yaml.SafeLoader)
        return list(_nodes('', root))
    except OSError as error:
        raise ValueError(f'{path}: {error.strerror}') from error
    except (yaml.YAMLError, ValueError) as error:
        raise ValueError(f'{path}: not a file of parameters: {_one_line(error)}') from error


def read_assignment(text: str) -> Given:
    """The value in ``name:=value`` or ``node:name:=value``, as ``-p`` takes it.

    :raises ValueError: it has another form.
    """
    left, separator, value = text.partition(':=')
    node, _, name = left.rpartition(':')
    if not separator or not name:
        raise ValueError(f'{text}: expected name:=value or node:name:=value')
    try:
        return Given(
            f'/{node}' if node else '/**', name, _value(yaml.compose(value, yaml.SafeLoader))
        )
    except (yaml.YAMLError, ValueError) as error:
        raise ValueError(f'{text}: {_one_line(error)}') from error


def namespaces_of(given: Iterable[Given], names: Iterable[str]) -> set[str]:
    """The namespaces in which the values name one of the nodes; the root is ``/``."""
    owners = [item.nodes.rpartition('/') for item in given if '*' not in item.nodes]
    return {namespace or '/' for namespace, _, name in owners if name in names}


def _nodes(path: str, tree: yaml.Node | None) -> Iterator[Given]:
    if not isinstance(tree, yaml.MappingNode):
        raise ValueError(f'{path or "the file"}: expected a node name and its ros__parameters')
    for key, content in tree.value:
        if key.value == 'ros__parameters':
            for name, value in _parameters('', content):
                yield Given(path, name, value)
        else:
            yield from _nodes('/'.join([path, key.value.strip('/')]), content)


def _parameters(prefix: str, tree: yaml.Node) -> Iterator[tuple[str, Any]]:
    if not isinstance(tree, yaml.MappingNode):
        raise ValueError(f'line {tree.start_mark.line + 1}: expected a parameter and its value')
    for key, content in tree.value:
        name = prefix + key.value
        if isinstance(content, yaml.MappingNode):
            yield from _parameters(f'{name}.', content)
        else:
            yield name, _value(content)


def _value(node: yaml.Node | None) -> Any:
    """What rcl takes a scalar for: its rules are not those of PyYAML, such as for 1e-6 and 1:30."""
    if isinstance(node, yaml.SequenceNode):
        return [_value(item) for item in node.value]
    if not isinstance(node, yaml.ScalarNode):
        raise ValueError('expected a value')
    text: str = node.value
    if node.style in ('"', "'"):
        return text
    if _TRUE.fullmatch(text) or _FALSE.fullmatch(text):
        return _TRUE.fullmatch(text) is not None
    if _INT.fullmatch(text):
        return int(text, 16 if 'x' in text.lower() else 8 if text.lstrip('+-')[0] == '0' else 10)
    if _FLOAT.fullmatch(text):
        return float(text.lower().replace('.i', 'i').replace('.n', 'n'))
    return text


def _one_line(error: Exception) -> str:
    return ' '.join(str(error).split())
