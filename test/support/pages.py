"""The pages of the documents."""

import re

from support.paths import ROOT

README = ROOT / 'README.md'
FENCE = re.compile(r'^( *)```(\w*)\n(.*?)^\1```$', re.MULTILINE | re.DOTALL)


def blocks(path, language):
    """The code blocks of a page in a language."""
    found = FENCE.findall(path.read_text())
    return [text.replace('\n' + indent, '\n') for indent, kind, text in found if kind == language]
