"""The server: one page, and a websocket for each browser that shows it."""

import asyncio
from collections.abc import Awaitable
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
import contextlib
import json
from pathlib import Path
import sys
import time
from typing import Any
from typing import TypeVar

from aiohttp import web
from aiohttp import WSMsgType

from colortrack_ros.tuner.commands import parse
from colortrack_ros.tuner.gate import COOKIE
from colortrack_ros.tuner.gate import Gate
from colortrack_ros.tuner.session import Session
from colortrack_ros.tuner.settings import described
from colortrack_ros.tuner.view import ShownFrame

PAGE = Path(__file__).with_name('page')

LARGEST_MESSAGE = 1 << 16
"""Maximum size of a message from the page [bytes]: the corners of a hundred regions take less."""

MOST_PEOPLE = 16
"""Maximum number of browsers at once. Assumed: a class in front of one camera; each further one
costs only the sending of pictures, which are encoded once."""

QUIET_SECONDS = 20.0
"""A browser that has not answered for this long is gone [s]. Assumed: with half of it a phone that
sleeps for a moment is cut off; with twice as much its place stays taken for longer."""

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]
Result = TypeVar('Result')


class Server:
    """Serves the page, and plays the recording while somebody watches.

    All work on the session is done in one thread, so that connections never wait for it. Each
    browser gets the newest picture once it has shown the previous one: a slow one misses pictures,
    and nobody waits for it. :param session: shared by the browsers. :param gate: decides which
    requests are accepted.
    """

    def __init__(self, session: Session, gate: Gate) -> None:
        self._session, self._gate = session, gate
        self._thread = ThreadPoolExecutor(1, 'workbench')
        self._people: set[Browser] = set()
        self._wake = asyncio.Event()
        self._encoded: ShownFrame | None = None
        self._state = ''
        self.app = web.Application(middlewares=[web.middleware(self._guarded())])
        self.app.router.add_get('/', self._page)
        self.app.router.add_get('/socket', self._socket)
        self.app.router.add_get('/snapshot', self._snapshot)
        self.app.router.add_static('/page', PAGE)
        self.app.cleanup_ctx.append(self._playing)

    def _guarded(self) -> Any:
        async def guarded(request: web.Request, handler: Handler) -> web.StreamResponse:
            token = request.query.get('token', request.cookies.get(COOKIE, ''))
            refusal = self._gate.refusal(request.headers, token)
            if refusal:
                return _safe(web.Response(status=403, text=f'{refusal}\n'), request)
            try:
                return _safe(await handler(request), request)
            except web.HTTPException as answer:
                _safe(answer, request)
                raise

        return guarded

    async def _page(self, request: web.Request) -> web.StreamResponse:
        """The page; a token in the URL is moved to a cookie."""
        if 'token' in request.query:
            answer = web.HTTPFound('/')
            answer.set_cookie(COOKIE, self._gate.token, httponly=True, samesite='Strict')
            raise answer
        return web.FileResponse(PAGE / 'index.html')

    async def _snapshot(self, _: web.Request) -> web.StreamResponse:
        """The material for a bug report, as a file to download."""
        try:
            content = await self._in_thread(self._session.snapshot)
        except ValueError as error:
            raise web.HTTPNotFound(text=f'{error}\n') from error
        name = time.strftime('tuner-%Y%m%d-%H%M%S.zip')
        headers = {'Content-Disposition': f'attachment; filename="{name}"'}
        return web.Response(body=content, content_type='application/zip', headers=headers)

    async def _socket(self, request: web.Request) -> web.StreamResponse:
        if len(self._people) >= MOST_PEOPLE:
            raise web.HTTPServiceUnavailable(text=f'{MOST_PEOPLE} browsers are enough\n')
        socket = web.WebSocketResponse(
            max_msg_size=LARGEST_MESSAGE,
            heartbeat=QUIET_SECONDS,
            compress=False,  # compression would not make JPEG and PNG smaller
        )
        await socket.prepare(request)
        browser = Browser(socket)
        self._people.add(browser)
        await socket.send_str(json.dumps({'is': 'hello', 'parameters': described()}))
        await self._refresh()
        self._wake.set()
        sending = asyncio.create_task(self._feed(browser))
        try:
            async for message in socket:
                if message.type == WSMsgType.TEXT:
                    await self._answer(browser, message.data)
                elif message.type == WSMsgType.BINARY:
                    await socket.send_str(_refused('expected a text'))
        except ConnectionError:  # it disconnected in the meantime
            pass
        finally:
            self._people.discard(browser)
            sending.cancel()
            with contextlib.suppress(asyncio.CancelledError, ConnectionError):
                await sending
        return socket

    async def _answer(self, browser: 'Browser', text: str) -> None:
        try:
            command, fields = parse(text)
            if command == 'shown':
                browser.has_shown()
                return
            reply = await self._in_thread(lambda: self._carry_out(command, fields))
        except ValueError as error:
            await browser.socket.send_str(_refused(str(error)))
            return
        except Exception as error:  # our fault: everybody else continues
            await browser.socket.send_str(_refused(f'{type(error).__name__}: {error}'))
            return
        if reply:
            await browser.socket.send_str(json.dumps(reply))
        self._tell()
        self._wake.set()

    def _carry_out(self, command: str, fields: dict[str, Any]) -> dict[str, Any] | None:
        """Carry out a command, and everything that browsers then wait for, before less urgent
        work.
        """
        reply = self._session.do(command, fields)
        self._note_state()
        if any(one.ready for one in self._people):
            self._newest()
        return reply

    async def _feed(self, browser: 'Browser') -> None:
        """Send updates as fast as the browser takes them."""
        with contextlib.suppress(ConnectionError):
            while True:
                await browser.changed.wait()
                browser.changed.clear()
                view = self._session.bench.view
                if browser.ready and view is not None and browser.view is not view:
                    browser.ready = False
                    if self._encoded is not view:
                        view = await self._in_thread(self._newest) or view
                    await browser.show(view)
                # After the picture, which is decoded while this is displayed.
                if browser.state is not self._state:
                    browser.state = self._state
                    await browser.socket.send_str(self._state)

    def _newest(self) -> ShownFrame | None:
        """The newest view, encoded, which takes a while, once for all browsers."""
        view = self._session.bench.view
        if view is not None and view is not self._encoded:
            view.encoded()
            self._encoded = view
        return view

    async def _refresh(self) -> None:
        """Notify all browsers of the new state."""
        await self._in_thread(self._note_state)
        self._tell()

    def _note_state(self) -> None:
        state = json.dumps(self._session.state())
        self._state = state if state != self._state else self._state

    def _tell(self) -> None:
        for browser in self._people:
            browser.changed.set()

    async def _playing(self, _: web.Application) -> Any:
        task = asyncio.create_task(self._work())
        yield
        for browser in list(self._people):
            await browser.socket.close()
        task.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await task
        self._thread.shutdown()

    async def _work(self) -> None:
        """Play, and catch up, while somebody watches."""
        while True:
            try:
                await self._work_on()
            except Exception as error:  # of any kind
                self._session.bench.pause()
                print(f'tuner: {type(error).__name__}: {error}', file=sys.stderr, flush=True)
                await self._wake.wait()  # for the next command: what failed would fail again
                self._wake.clear()

    async def _work_on(self) -> None:
        bench = self._session.bench
        due = time.monotonic()
        while True:
            if bench.playing and self._people:
                due = max(due + 1 / bench.footage.rate, time.monotonic())
                if await self._in_thread(bench.step):
                    self._tell()
                elif not bench.playing:
                    await self._refresh()
                await asyncio.sleep(max(due - time.monotonic(), 0))
            elif not await self._in_thread(self._session.work):
                await self._refresh()
                await self._wake.wait()
                self._wake.clear()

    async def _in_thread(self, work: Callable[[], Result]) -> Result:
        return await asyncio.get_running_loop().run_in_executor(self._thread, work)


class Browser:
    """One browser.

    :ivar changed: set when there may be something new to send.
    :ivar ready: whether it has shown the last picture.
    :ivar view: the last one sent to it.
    """

    def __init__(self, socket: web.WebSocketResponse) -> None:
        self.socket = socket
        self.changed = asyncio.Event()
        self.ready = True
        self.state = ''
        self.view: ShownFrame | None = None

    async def show(self, view: ShownFrame) -> None:
        """Send it a view, with the picture unless it has that."""
        has_picture = self.view is not None and self.view.picture is view.picture
        self.view = view
        await self.socket.send_bytes(view.encoded(has_picture=has_picture))

    def has_shown(self) -> None:
        """Note that the last picture is on its screen."""
        self.ready = True
        self.changed.set()


def _refused(why: str) -> str:
    return json.dumps({'is': 'refused', 'why': why})


def _safe(answer: Any, request: web.Request) -> Any:
    """Add headers that keep the page from loading anything from elsewhere."""
    if not answer.prepared:
        answer.headers['Content-Security-Policy'] = (
            "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
            f"connect-src 'self' ws://{request.host}; frame-ancestors 'none'; base-uri 'none'"
        )
        answer.headers['X-Content-Type-Options'] = 'nosniff'
        answer.headers['Referrer-Policy'] = 'no-referrer'
        answer.headers['Cache-Control'] = 'no-store'
    return answer
