"""Who may talk to the workbench, and how much: everything is checked before a route sees it.

    Guard       the host it was reached by, the token, where a request comes from, sizes, headers

The address that is printed holds a random token; opening it once turns the token into a cookie that
no script can read and no other site sends along. A name that resolves to this machine (DNS
rebinding) is refused by the Host header, a page of another port by Origin and Sec-Fetch-Site, and
what changes something must come in a type that a foreign form cannot send.
"""

from __future__ import annotations

import ipaddress
import secrets
from collections.abc import Mapping
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import JSONResponse, PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

TOKEN_HEADER = "x-cbpt-token"
MOST_JSON_BYTES = 1 << 20

# Styles stay open, as plotly writes them into elements; scripts come from files of this server.
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; font-src 'self'; connect-src 'self'; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'"
)
HEADERS = {
    "content-security-policy": POLICY,
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-resource-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
    "cache-control": "no-store",
}
_TYPES = {"application/json", "application/octet-stream"}


class Guard:
    """Around the whole application. hosts: names it may be reached by; addresses: whether any
    address of the machine will do, where it listens to more than itself."""

    def __init__(
        self, app: ASGIApp, token: str, port: int, hosts: frozenset[str], addresses: bool = False
    ) -> None:
        self.app, self.token, self.port = app, token, port
        self.hosts, self.addresses = hosts, addresses
        # Cookies know no ports: two workbenches must not take each other's.
        self.cookie = f"cbpt_{port}"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return

        async def sealed(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in HEADERS.items():
                    headers.setdefault(name, value)
            await send(message)

        if scope["type"] == "http":
            refused = self.refused(scope)
            await (refused or self.app)(scope, receive, sealed)

    def refused(self, scope: Scope) -> Response | None:
        """The answer to who may not enter; None to who may."""
        headers = Headers(scope=scope)
        if not self._is_ours(headers.get("host", "")):
            return PlainTextResponse("this is not the name of this server", 421)
        query = parse_qs(scope.get("query_string", b"").decode("latin-1"))
        given = query.get("token", [""])[0]
        if scope["path"] == "/" and scope["method"] == "GET" and self._is_token(given):
            # The token leaves the address bar, and with it history and screenshots.
            found = RedirectResponse("/", 303)
            found.set_cookie(self.cookie, self.token, httponly=True, samesite="strict", path="/")
            return found
        if not self._is_token(headers.get(TOKEN_HEADER) or self._of_cookie(headers)):
            words = "open the address that `cbpt workbench` has printed: it holds the key"
            return _refusal(scope, words, 403)
        return self._foreign(scope, headers)

    def _foreign(self, scope: Scope, headers: Mapping[str, str]) -> Response | None:
        """A request that another page has made, or could have."""
        origin = headers.get("origin")
        if origin is not None and origin != f"http://{headers.get('host')}":
            return _refusal(scope, "another page may not ask here", 403)
        # A link may lead here, but to the page alone.
        to_page = scope["path"] == "/" and scope["method"] == "GET"
        if not to_page and headers.get("sec-fetch-site", "none") not in ("none", "same-origin"):
            return _refusal(scope, "another page may not ask here", 403)
        if scope["method"] not in ("GET", "HEAD"):
            kind = headers.get("content-type", "").partition(";")[0].strip().lower()
            if kind not in _TYPES:
                return _refusal(scope, f"expected {' or '.join(sorted(_TYPES))}", 415)
        return None

    def _is_ours(self, host: str) -> bool:
        name, _, port = host.rpartition(":") if host[-1:] != "]" else (host, "", "80")
        if not name:
            name, port = host, "80"
        if port != str(self.port):
            return False
        if name in self.hosts:
            return True
        # An address cannot be made to point elsewhere, as a name can.
        try:
            ipaddress.ip_address(name.strip("[]"))
        except ValueError:
            return False
        return self.addresses

    def _is_token(self, given: str) -> bool:
        return secrets.compare_digest(given.encode(), self.token.encode())

    def _of_cookie(self, headers: Mapping[str, str]) -> str:
        try:
            found = SimpleCookie(headers.get("cookie", "")).get(self.cookie)
        except CookieError:
            return ""
        return found.value if found else ""


def _refusal(scope: Scope, words: str, status: int) -> Response:
    if scope["path"].startswith("/api/"):
        return JSONResponse({"error": words}, status)
    return PlainTextResponse(words, status)
