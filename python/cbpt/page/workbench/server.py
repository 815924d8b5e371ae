"""The workbench's routes: HTTP on one side, a `Session` on the other.

    application     the ASGI application, guarded

    GET  /                      the page; with ?token= it sets the cookie first
    GET  /page.css, /main.js,   its files; /plotly.min.js from the plotly package
         /lib/*.js, ...
    GET  /api/document          the document, or null
    POST /api/upload?name=      bytes of a file -> {ready, message, columns, quantities, sheets,
                                problem};
                                &more=1: another file follows, with which it is read
    POST /api/change?name=      bytes of a second table -> what changed from the one shown
    POST /api/columns           {columns {header: meaning}, sheet} -> the same
    POST /api/forget            files that were refused or are in doubt are wanted no more
    POST /api/leave_out         {rows} of those shown that count no more; none: all count again
    POST /api/diagnose          {seed} -> the job
    GET  /api/job               {state, stage, share, seconds, error}
    POST /api/cancel            the job
    GET  /api/isolability       {isolability, why}: worked out when first asked for
    GET  /api/table             {checks, loops}: worked out when first asked for
    POST /api/model             {effects} -> {model, curves, ladder}
    POST /api/shown             {effects}: a model that the page had is looked at
    POST /api/own/check         an own effect -> {ok, message, column, field, notes}
    POST /api/own/fit           an own effect, {effects} beside it -> {model, curves, ladder}
    POST /api/drive             {load, design} -> the section `drive`; with {effects} its loop too
    GET  /api/export/WHAT       json, csv, case, command; ?effects=a,b

Mistakes of the input are 400 with {error}; what cannot be done now is 409.
"""

from __future__ import annotations

import json
import math
import secrets
import sys
import traceback
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any
from zlib import crc32

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.datastructures import MutableHeaders, QueryParams
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from cbpt.errors import CbptError, told
from cbpt.page.document.plain import to_json
from cbpt.page.report import WEB, plotly_path
from cbpt.page.workbench.guard import MOST_JSON_BYTES, Guard
from cbpt.page.workbench.session import NotNow, Session
from cbpt.page.workbench.uploads import MOST_BYTES, on_page

_KINDS = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
}
_LONGEST = 1000


class Wrong(Exception):
    """A request that is none of this page's: status and words."""

    def __init__(self, status: int, words: str) -> None:
        super().__init__(words)
        self.status = status


def application(
    session: Session,
    token: str,
    port: int,
    hosts: frozenset[str] = frozenset({"127.0.0.1", "localhost", "[::1]"}),
    addresses: bool = False,
) -> ASGIApp:
    """The workbench of a session. Arguments: see `Guard`."""

    @asynccontextmanager
    async def lifespan(app: Starlette) -> AsyncIterator[None]:
        yield
        session.close()

    page = secrets.token_hex(8)
    routes = [
        *_static(page),
        Route("/api/document", _getter(lambda r: session.document() or "null")),
        Route("/api/job", _getter(lambda r: session.job())),
        Route("/api/isolability", _getter(lambda r: session.isolability())),
        Route("/api/table", _getter(lambda r: session.table())),
        Route("/api/export/{what}", _export(session)),
        Route("/api/upload", _handed(session.take), methods=["POST"]),
        Route("/api/change", _handed(lambda n, raw, _: session.changed(n, raw)), methods=["POST"]),
    ]
    posts: dict[str, Callable[[dict[str, Any]], object]] = {
        "columns": lambda b: session.map_columns(
            _texts(b, "columns"), None if b.get("sheet") is None else _text(b, "sheet")
        ),
        "forget": lambda b: session.forget(),
        "leave_out": lambda b: session.leave_out(_rows(b)),
        "diagnose": lambda b: session.start(_seed(b), b.get("own") is True),
        "cancel": lambda b: session.cancel(),
        "model": lambda b: session.model(_list(b, "effects")),
        "shown": lambda b: session.shown(_list(b, "effects")),
        "own/check": session.check_own,
        "own/fit": lambda b: session.fit_own(b, _list(b, "effects") if "effects" in b else []),
        "datasheet": lambda b: {"html": session.datasheet()},
        "drive": lambda b: session.drive(
            _numbers(b, "load"),
            _numbers(b, "design"),
            _list(b, "effects") if "effects" in b else None,
        ),
    }
    routes += [Route(f"/api/{name}", _poster(act), methods=["POST"]) for name, act in posts.items()]
    app = Starlette(routes=routes, lifespan=lifespan)
    return Guard(_Current(app, page, session), token, port, hosts, addresses)


class _Current:
    """Refuses a page that an earlier workbench has sent from this port, or that shows other files
    than those that are open now: what it shows is of other readings than the answers would be.

    Answers say of which files they are, as others may have been opened while they were made.
    """

    def __init__(self, app: ASGIApp, page: str, session: Session) -> None:
        self.app, self.page, self.session = app, page, session

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http" or not scope["path"].startswith("/api/"):
            await self.app(scope, receive, send)
            return

        async def named(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message)["x-cbpt-opened"] = str(self.session.opened)
            await send(message)

        asked = QueryParams(scope["query_string"])
        words = None
        if asked.get("page", self.page) != self.page:
            words = (
                "this page belongs to a workbench that has ended; reload it to see the present one"
            )
        elif asked.get("opened", str(self.session.opened)) != str(self.session.opened):
            words = "other files have been opened in another window; reload this one to see them"
        answer = JSONResponse({"error": words}, 409) if words else self.app
        await answer(scope, receive, named)


# --- files --------------------------------------------------------------------------------


def _static(page: str) -> list[Route]:
    """The page's own files, by name: no path of a request ever touches the disk. page: the key by
    which it is known which workbench has sent it."""
    plotly = f"plotly.min.js?{_mark(plotly_path())}"
    found = []
    for path in sorted(WEB.rglob("*.*")):
        kind = _KINDS.get(path.suffix)
        if kind:
            name = path.relative_to(WEB).as_posix()
            address = "/" if name == "index.html" else f"/{name}"
            content = path.read_text(encoding="utf-8")
            # Kept by the browser under a name that another version of the library has not.
            content = content.replace('"plotly.min.js"', f'"{plotly}"')
            content = content.replace("?page=", f"?page={page}") if address == "/" else content
            found.append(Route(address, _file(content.encode(), kind)))
    return [*found, Route("/plotly.min.js", _plotly)]


def _mark(path: Path) -> str:
    """Tells one version of the library from another by what is in the file: its size, beginning,
    where the version stands, and end. Its time does not, as reproducible installs give all versions
    the same, nor does the package's version where the file was exchanged; to read all of it would
    delay the start."""
    size = path.stat().st_size
    with path.open("rb") as file:
        ends = file.read(1024)
        file.seek(max(size - 1024, 0))
        ends += file.read()
    return f"{size:x}-{crc32(ends):08x}"


def _file(content: bytes, kind: str) -> Callable[[Request], Awaitable[Response]]:
    async def serve(request: Request) -> Response:
        return Response(content, media_type=kind)

    return serve


async def _plotly(request: Request) -> Response:
    content = await run_in_threadpool(plotly_path().read_bytes)
    headers = {"cache-control": "private, max-age=31536000, immutable"}
    return Response(content, media_type=_KINDS[".js"], headers=headers)


# --- answers ------------------------------------------------------------------------------


async def _answered(act: Callable[[], object]) -> Response:
    """What a session says, or why it does not."""
    try:
        found = await run_in_threadpool(act)
    except NotNow as error:
        return JSONResponse({"error": str(error)}, 409)
    except CbptError as error:
        return JSONResponse({"error": told(error, on_page)}, 400)
    except Wrong as error:
        return JSONResponse({"error": str(error)}, error.status)
    except Exception:
        # Told where the server was started; the page need not see its inside.
        traceback.print_exc(file=sys.stderr)
        words = "the server has met a mistake of its own; see where it was started"
        return JSONResponse({"error": words}, 500)
    text = found if isinstance(found, str) else to_json(found)
    return Response(text, media_type="application/json")


def _getter(act: Callable[[Request], object]) -> Callable[[Request], Awaitable[Response]]:
    async def get(request: Request) -> Response:
        return await _answered(lambda: act(request))

    return get


def _poster(act: Callable[[dict[str, Any]], object]) -> Callable[[Request], Awaitable[Response]]:
    async def post(request: Request) -> Response:
        try:
            raw = await _body(request, MOST_JSON_BYTES)
        except Wrong as error:
            return JSONResponse({"error": str(error)}, error.status)
        return await _answered(lambda: act(_json(raw)))

    return post


def _handed(take: Callable[[str, bytes, bool], object]) -> Callable[[Request], Awaitable[Response]]:
    async def post(request: Request) -> Response:
        name, more = request.query_params.get("name", ""), "more" in request.query_params
        try:
            raw = await _body(request, MOST_BYTES)
        except Wrong as error:
            return JSONResponse({"error": str(error)}, error.status)
        return await _answered(lambda: take(name, raw, more))

    return post


def _export(session: Session) -> Callable[[Request], Awaitable[Response]]:
    async def get(request: Request) -> Response:
        effects = [e for e in request.query_params.get("effects", "").split(",") if e]
        made: list[tuple[str, str, str]] = []
        answer = await _answered(
            lambda: made.append(session.exported(request.path_params["what"], effects))
        )
        if not made:
            return answer
        text, kind, name = made[0]
        headers = {"content-disposition": f'attachment; filename="{_ascii(name)}"'}
        return Response(text, media_type=f"{kind}; charset=utf-8", headers=headers)

    return get


def _ascii(name: str) -> str:
    return "".join(sign if sign.isascii() else "_" for sign in name)


# --- what comes in ------------------------------------------------------------------------


async def _body(request: Request, most: int) -> bytes:
    """The body, never more of it than may be."""
    words = f"the request is longer than {most:,} bytes"
    told = request.headers.get("content-length", "0")
    if not told.isdecimal() or int(told) > most:
        raise Wrong(413, words)
    parts, size = [], 0
    try:
        async for part in request.stream():
            size += len(part)
            if size > most:
                raise Wrong(413, words)
            parts.append(part)
    except ClientDisconnect:
        raise Wrong(400, "the request ended early") from None
    return b"".join(parts)


def _json(raw: bytes) -> dict[str, Any]:
    def refuse(word: str) -> float:
        raise ValueError(word)

    try:
        found = json.loads(raw or b"{}", parse_constant=refuse)
    except (ValueError, RecursionError):
        raise Wrong(400, "the request is no JSON") from None
    if not isinstance(found, dict):
        raise Wrong(400, "the request is no JSON object")
    return found


def _text(body: dict[str, Any], key: str) -> str:
    value = body.get(key)
    if not isinstance(value, str) or len(value) > _LONGEST:
        raise Wrong(400, f"{key}: expected text of at most {_LONGEST} characters")
    return value


def _texts(body: dict[str, Any], key: str) -> dict[str, str]:
    value = body.get(key, {})
    if not isinstance(value, dict) or not all(isinstance(v, str) for v in value.values()):
        raise Wrong(400, f"{key}: expected texts by name")
    return value


def _list(body: dict[str, Any], key: str) -> list[str]:
    value = body.get(key)
    if not isinstance(value, list) or not all(isinstance(v, str) for v in value):
        raise Wrong(400, f"{key}: expected a list of texts")
    return value


def _rows(body: dict[str, Any]) -> list[int]:
    value = body.get("rows")
    if not isinstance(value, list) or any(type(v) is not int for v in value):
        raise Wrong(400, "rows: expected a list of whole numbers")
    return value


def _numbers(body: dict[str, Any], key: str) -> dict[str, float]:
    value = body.get(key) or {}
    try:
        if isinstance(value, dict) and not any(isinstance(v, str | bool) for v in value.values()):
            found = {name: float(v) for name, v in value.items()}
            if all(map(math.isfinite, found.values())):
                return found
    except (TypeError, OverflowError):
        pass
    raise Wrong(400, f"{key}: expected numbers by name")


def _seed(body: dict[str, Any]) -> int:
    value = body.get("seed", 0)
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value < 2**63:
        raise Wrong(400, "seed: expected a whole number")
    return value
