"""Decides who may talk to the server: no page of another site, and no foreign name that points
here.
"""

from collections.abc import Mapping
import hmac
import ipaddress
import secrets
import socket
from urllib.parse import urlsplit

COOKIE = 'tuner_token'

TOKEN_BYTES = 16
"""Random bytes of a token: 128 bits cannot be guessed."""


def is_loopback(address: str) -> bool:
    """Whether an address can be reached only from this machine."""
    if address == 'localhost':
        return True
    try:
        return ipaddress.ip_address(address).is_loopback
    except ValueError:
        return False


class Gate:
    """Decides which requests are accepted.

    On a loopback address, everybody on this machine is; elsewhere, everybody who has the token. The
    header Host must name this server, since otherwise a page could point its own name here (DNS
    rebinding), and Origin, if present, must be this server. :param address: on which the server
    listens. :ivar port: of the server, once it is known.
    :ivar token: empty on a loopback address.
    """

    def __init__(self, address: str) -> None:
        self._address, self.port = address, 0
        self.token = '' if is_loopback(address) else secrets.token_urlsafe(TOKEN_BYTES)

    @property
    def url(self) -> str:
        """URL of the page, including the token."""
        host = f'[{self._address}]' if ':' in self._address else self._address
        if self._address in ('0.0.0.0', '::'):
            host = socket.gethostname()
        return f'http://{host}:{self.port}/' + (f'?token={self.token}' if self.token else '')

    def refusal(self, headers: Mapping[str, str], token: str) -> str:
        """Why a request is refused; empty if it is accepted.

        :param token: from its cookie or its URL.
        """
        host = headers.get('Host', '')
        if not self._is_own(host):
            return f'Host: expected the address of this server, got {host!r}'
        origin = headers.get('Origin')
        if origin is not None and origin != f'http://{host}':
            return f'Origin: expected http://{host}, got {origin!r}'
        if self.token and not hmac.compare_digest(self.token.encode(), token.encode()):
            return 'token: expected the address that the tuner has told at its start'
        return ''

    def _is_own(self, host: str) -> bool:
        try:
            parts = urlsplit(f'//{host}')
            name, port = parts.hostname or '', parts.port or 80
        except ValueError:
            return False
        if port != self.port or parts.username is not None or parts.path:
            return False
        if not self.token:
            return is_loopback(name)
        names = {self._address.lower(), 'localhost', socket.gethostname().lower()}
        return name in names or _is_address(name)


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
