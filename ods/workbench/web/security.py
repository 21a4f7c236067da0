"""Who may speak to the workbench: a browser on this machine that came by a link from the terminal, no other page."""

import secrets
from collections.abc import Callable
from http import HTTPStatus
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

HOSTS = ("127.0.0.1", "localhost")
"""Names that the server goes by; under any other it does not answer, whatever that name leads to."""
HEADERS = {
    "Content-Security-Policy": (
        "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; style-src 'self' 'unsafe-inline'; "
        "img-src 'self' data: blob:; media-src 'self' blob:; font-src 'self' data:; worker-src 'self' blob:; "
        "frame-ancestors 'none'; base-uri 'self'; form-action 'self'"
    ),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
}
"""Of every answer: the browser itself fetches nothing from another host. NiceGUI compiles templates: unsafe-eval."""
BROWSER = "browser"
"""Key in a request's state of the browser that sent it."""


class Gate:
    """Lets pass what carries the cookie that a link of the terminal was exchanged for, and comes from no foreign page.

    A link is good for one browser; with each use the next one is issued.
    """

    def __init__(self, app: ASGIApp, cookie: str, issue: Callable[[str], None]) -> None:
        """cookie: its name. issue: gets each new one-time token."""
        self.app = app
        self._cookie, self._issue = cookie, issue
        self._browsers: set[str] = set()
        self._token = ""
        self._renew()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer as an ASGI application."""
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        browser = self._browser_of(headers)
        answer = self._refusal(scope, headers, browser)
        if answer is not None:
            await answer(scope, receive, send)
            return
        scope.setdefault("state", {})[BROWSER] = browser
        await self.app(scope, receive, _with_headers(send))

    def _refusal(self, scope: Scope, headers: Headers, browser: str) -> Response | None:
        """Return what is answered in place of the application, if anything is."""
        origin = headers.get("origin")
        if origin != f"http://{headers.get('host', '')}" and (origin or scope["type"] == "websocket"):
            return _refused("The workbench does not answer to other pages.")
        token = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])[0]
        if scope["type"] == "http" and scope["path"] == "/" and token:
            return self._admit(token, browser)
        return None if browser else _refused("Please open the link that `ods workbench` shows in its terminal.")

    def _admit(self, token: str, browser: str) -> Response:
        """Exchange a token for a cookie; a browser that has one may come again by its old link."""
        if not secrets.compare_digest(token.encode(), self._token.encode()):
            return RedirectResponse("/", HTTPStatus.SEE_OTHER) if browser else _refused(
                "This link has been used: please open the newest one that `ods workbench` shows in its terminal."
            )  # fmt: skip
        self._renew()
        browser = secrets.token_urlsafe(32)
        self._browsers.add(browser)
        answer = RedirectResponse("/", HTTPStatus.SEE_OTHER)
        answer.set_cookie(self._cookie, browser, httponly=True, samesite="strict")
        return answer

    def _renew(self) -> None:
        self._token = secrets.token_urlsafe(32)
        self._issue(self._token)

    def _browser_of(self, headers: Headers) -> str:
        """Return the browser's cookie; empty: it has none that is ours."""
        try:
            cookies = SimpleCookie(headers.get("cookie", ""))
        except CookieError:
            return ""
        morsel = cookies.get(self._cookie)
        return morsel.value if morsel is not None and morsel.value in self._browsers else ""


def _refused(why: str) -> Response:
    closing = {"Connection": "close"}  # a body is not waited for
    return PlainTextResponse(f"{why}\n", HTTPStatus.FORBIDDEN, HEADERS | closing)


def _with_headers(send: Send) -> Send:
    async def sending(message: Message) -> None:
        if message["type"] == "http.response.start":
            MutableHeaders(scope=message).update(HEADERS)
        await send(message)

    return sending
