"""What stands before every request: who asks, from which page, under which name of this machine, and how much is sent.

A page of a foreign site that is open in the same browser can send requests to a server on this machine, and, if the name of its
own site is made to point here (DNS rebinding), read the answers. So three things must fit, for pages and for
websockets: the name that the browser asked for, the page that the request comes from, and a cookie that only whoever
opened the printed address has.
"""

from __future__ import annotations

import asyncio
import hmac
import ipaddress
import secrets
import socket
from collections.abc import Awaitable, Callable, MutableMapping
from dataclasses import dataclass, field
from http.cookies import CookieError, SimpleCookie
from typing import Any, TypeAlias
from urllib.parse import parse_qs, quote

from friction_models.common.errors import shown
from friction_models.common.markup import document, escape

Scope: TypeAlias = MutableMapping[str, Any]
Message: TypeAlias = MutableMapping[str, Any]
Receive: TypeAlias = Callable[[], Awaitable[Message]]
Send: TypeAlias = Callable[[Message], Awaitable[None]]
App: TypeAlias = Callable[[Scope, Receive, Send], Awaitable[None]]

#: Most that a request may send [byte].
LARGEST = 200_000_000
LOOPBACK = ("127.0.0.1", "localhost", "[::1]")
#: Everything comes from here; the pages' own framework needs inline scripts and compiles its templates in the browser.
POLICY = (
    "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; font-src 'self' data:; connect-src 'self'; object-src 'none'; base-uri 'self'; "
    "form-action 'self'; frame-ancestors 'none'"
)
_HEADERS = {
    "content-security-policy": POLICY,
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "x-frame-options": "DENY",
}
_STYLE = (
    "<style>body{font:17px/1.6 system-ui,sans-serif;max-width:40em;margin:12vh auto;padding:0 1em}"
    "input,button{font:inherit;padding:.4em .6em}</style>"
)


@dataclass
class Access:
    """Who may come in."""

    port: int
    #: Part of the printed address, and then the value of the cookie.
    token: str = field(default_factory=lambda: secrets.token_urlsafe(32), repr=False)
    #: Asked for where others on the network can reach the server; empty on loopback.
    password: str = field(default="", repr=False)
    #: Names of this machine beside the loopback ones.
    names: tuple[str, ...] = ()

    @property
    def cookie(self) -> str:
        """Name of the cookie: cookies do not know ports, so two workbenches need two names."""
        return f"tribofmu-{self.port}"

    def knows(self, host: str) -> bool:
        """Whether the browser asked for this machine by a name that only points here.

        Examples
        --------
        >>> access = Access(8420)
        >>> [access.knows(h) for h in ("127.0.0.1:8420", "localhost:8420", "evil.example:8420", "127.0.0.1:80")]
        [True, True, False, False]
        >>> shared = Access(8420, password="for the whole hall", names=("press-lab",))
        >>> [shared.knows(h) for h in ("10.0.0.5:8420", "press-lab:8420", "evil.example:8420")]
        [True, True, False]
        """
        name, _, port = host.rpartition(":")
        if not name or port != str(self.port):
            return False
        if name.lower() in LOOPBACK:
            return True
        # With a password others may ask: by number, which no foreign site can take over, or by the name of the machine.
        return bool(self.password) and (_is_number(name) or name.lower() in self.names)

    def right(self, given: str) -> bool:
        """Whether a cookie or a token is the right one."""
        return hmac.compare_digest(given.encode(), self.token.encode())

    def right_password(self, given: str) -> bool:
        """Whether a password is the right one."""
        return bool(self.password) and hmac.compare_digest(given.encode(), self.password.encode())


def machine_names() -> tuple[str, ...]:
    """Return the names under which others know this machine."""
    name = socket.gethostname().lower()
    return tuple(dict.fromkeys([name, name.partition(".")[0], f"{name.partition('.')[0]}.local"]))


def _is_number(name: str) -> bool:
    try:
        ipaddress.ip_address(name.strip("[]"))
    except ValueError:
        return False
    return True


class Guard:
    """ASGI application before another one; see the module."""

    def __init__(self, app: App, access: Access, largest: int = LARGEST) -> None:
        self.app, self.access, self.largest = app, access, largest
        self._one_at_a_time = asyncio.Lock()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or refuse it."""
        if scope["type"] not in {"http", "websocket"}:
            await self.app(scope, receive, send)
            return
        headers = _Headers(scope)
        hosts, origins = headers.all("host"), headers.all("origin")
        if len(hosts) != 1 or not self.access.knows(hosts[0]):
            said = "The workbench answers under the address that tribofmu app printed."
            await _refuse(scope, send, 403, said)
            return
        # A websocket always says from which page it comes; a page that is opened need not.
        own = f"{scope['scheme'].replace('ws', 'http')}://{hosts[0]}"
        foreign = any(o != own for o in origins) or (scope["type"] == "websocket" and not origins)
        other_site = headers.one("sec-fetch-site") in {"cross-site", "same-site"}
        if foreign or (other_site and not _is_navigation(scope, headers)):
            await _refuse(scope, send, 403, "The request comes from another page.")
            return
        if scope["type"] == "http" and await self._let_in(scope, headers, receive, send):
            return
        if not self.access.right(_cookie(headers.all("cookie"), self.access.cookie)):
            await self._stranger(scope, send)
            return
        announced = headers.one("content-length")
        if announced.isdigit() and int(announced[:20]) > self.largest:
            said = f"{shown(announced, 20)} byte are too many; at most {self.largest} are taken."
            await _refuse(scope, send, 413, said)
            return
        bounded = _Bounded(receive, self.largest)
        try:
            await self.app(scope, bounded if scope["type"] == "http" else receive, _with_headers(send))
        except RuntimeError as error:
            # What the framework says when the browser left before the page was ready.
            if not (bounded.over and "No response returned" in str(error)):
                raise

    async def _let_in(self, scope: Scope, headers: _Headers, receive: Receive, send: Send) -> bool:
        """Give the cookie to whoever has the token or the password; say whether the request was answered."""
        token = parse_qs(scope.get("query_string", b"").decode("latin-1")).get("token", [""])[0]
        if token and scope["method"] == "GET" and not self.access.password:
            if self.access.right(token):
                await self._welcome(send, scope["path"])
            else:
                await self._stranger(scope, send)
            return True
        if self.access.password and scope["path"] == "/login" and scope["method"] == "POST":
            body = await _body(receive, 10_000)
            given = parse_qs(body.decode("utf-8", "replace")).get("password", [""])[0]
            async with self._one_at_a_time:  # guessing takes a second a guess
                await asyncio.sleep(1.0)
            if self.access.right_password(given):
                await self._welcome(send, "/")
            else:
                await _answer(send, 401, _login("This is not the password."))
            return True
        return False

    async def _welcome(self, send: Send, path: str) -> None:
        """Set the cookie and go on: by a page of our own, since a strict cookie does not follow a link from elsewhere."""
        cookie = f"{self.access.cookie}={self.access.token}; HttpOnly; SameSite=Strict; Path=/"
        # Two slashes at the beginning would be the name of another machine.
        target = "/" + quote(path.lstrip("/\\"))
        page = document("Welcome", f'<meta http-equiv="refresh" content="0;url={escape(target)}">\n', "")
        await _answer(send, 200, page, [(b"set-cookie", cookie.encode())])

    async def _stranger(self, scope: Scope, send: Send) -> None:
        if scope["type"] == "http" and self.access.password:
            await _answer(send, 401, _login(""))
            return
        said = (
            "Open the address that tribofmu app printed in the terminal: it ends with a token. "
            "A workbench that was started anew has a new one."
        )
        await _refuse(scope, send, 401, said)


class _Bounded:
    """Receives a request, and ends it where it sends too much, whatever it announced."""

    def __init__(self, receive: Receive, largest: int) -> None:
        self.receive, self.left = receive, largest
        self.over = False

    async def __call__(self) -> Message:
        message = await self.receive()
        self.left -= len(message.get("body", b""))
        self.over = self.left < 0 or message["type"] == "http.disconnect"
        return {"type": "http.disconnect"} if self.over else message


class _Headers:
    """Headers of a request by name."""

    def __init__(self, scope: Scope) -> None:
        self._found: list[tuple[bytes, bytes]] = scope["headers"]

    def all(self, name: str) -> list[str]:
        return [
            value.decode("latin-1") for key, value in self._found if key.decode("latin-1").lower() == name
        ]

    def one(self, name: str) -> str:
        return next(iter(self.all(name)), "")


def _is_navigation(scope: Scope, headers: _Headers) -> bool:
    """Whether somebody followed a link: what is shown then is no secret of the page that holds the link."""
    return (
        scope["type"] == "http"
        and scope["method"] == "GET"
        and headers.one("sec-fetch-mode") == "navigate"
        and headers.one("sec-fetch-dest") == "document"
    )


def _cookie(texts: list[str], name: str) -> str:
    for text in texts:
        try:
            found = SimpleCookie(text).get(name)
        except CookieError:
            continue
        if found is not None:
            return found.value
    return ""


async def _body(receive: Receive, largest: int) -> bytes:
    body, more = b"", True
    while more and len(body) <= largest:
        message = await receive()
        body += message.get("body", b"")
        more = bool(message.get("more_body")) and message["type"] == "http.request"
    return body[:largest]


def _with_headers(send: Send) -> Send:
    async def dressed(message: Message) -> None:
        if message["type"] == "http.response.start":
            present = {key.lower() for key, _ in message.get("headers", [])}
            more = [(k.encode(), v.encode()) for k, v in _HEADERS.items() if k.encode() not in present]
            message = {**message, "headers": [*message.get("headers", []), *more]}
        await send(message)

    return dressed


async def _refuse(scope: Scope, send: Send, status: int, said: str) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 1008, "reason": said[:100]})
        return
    await _answer(send, status, document("Not here", _STYLE, f"<h1>Not here</h1><p>{escape(said)}</p>"))


def _login(problem: str) -> str:
    form = (
        f'<h1>Workbench</h1><p role="alert">{escape(problem)}</p><form method="post" action="/login">'
        '<label>Password <input type="password" name="password" autocomplete="current-password" autofocus required></label> '
        "<button>Open</button></form>"
    )
    return document("Workbench", _STYLE, form)


async def _answer(send: Send, status: int, page: str, more: list[tuple[bytes, bytes]] | None = None) -> None:
    body = page.encode()
    headers = [
        (b"content-type", b"text/html; charset=utf-8"),
        (b"content-length", str(len(body)).encode()),
        (b"cache-control", b"no-store"),
        *(more or []),
    ]
    await _with_headers(send)({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": body})
