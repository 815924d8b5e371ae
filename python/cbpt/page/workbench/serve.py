"""The page live: a server on this machine alone, and the browser opened on it.

serve   runs until Ctrl-C
"""

from __future__ import annotations

import logging
import os
import secrets
import socket
import sys
import threading
import webbrowser
from importlib.util import find_spec
from math import ceil
from types import FrameType

from cbpt.errors import CbptError, InvalidInputError
from cbpt.lab.covariance.one_thread import one_blas_thread
from cbpt.page.workbench.session import CLOSING_S, Session

PORT = 8327
"""Taken where it is free: browsers keep the plotting library of an address, read and compiled."""
LOOPBACK = ("127.0.0.1", "localhost", "::1")


def serve(session: Session, host: str, port: int | None, open_browser: bool) -> None:
    """Serve a session. port: 0 is any that is free; None is `PORT`, or any where it is taken.

    Raises `CbptError` where it cannot.
    """
    if not all(map(find_spec, ("starlette", "uvicorn", "plotly"))):
        words = 'the workbench needs starlette, uvicorn and plotly: pip install "cbpt[workbench]"'
        raise CbptError(words)
    listening = _listening(host, port)
    port = listening.getsockname()[1]
    token = secrets.token_urlsafe(32)
    local = host in LOOPBACK
    hosts = {"127.0.0.1", "localhost", "[::1]"} | (set() if local else {host, socket.gethostname()})
    shown = host if local and host != "::1" else "[::1]" if local else socket.gethostname()
    address = f"http://{shown}:{port}/?token={token}"
    if not local:
        print(
            f"Warning: listening on {host}, so whoever has this address can read and change what "
            "is open here, and it travels unencrypted. 127.0.0.1 is the safe choice.",
            file=sys.stderr,
        )
    print(f"The workbench is at {address}\nCtrl-C ends it.", flush=True)
    if open_browser:
        threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()
    # Requests of the page, of a millisecond each, must not queue behind the work of a session.
    sys.setswitchinterval(2e-4)
    import uvicorn

    from cbpt.page.workbench.server import application

    class Server(uvicorn.Server):
        async def startup(self, sockets: list[socket.socket] | None = None) -> None:
            await super().startup(sockets)
            # After the page has been sent: the browser reads it meanwhile.
            threading.Thread(target=session.begin, daemon=True).start()

        def handle_exit(self, sig: int, frame: FrameType | None) -> None:
            session.stop()
            # A request that is cut off by Ctrl-C is no error to be told with a traceback.
            logging.getLogger("uvicorn.error").setLevel(logging.CRITICAL)
            super().handle_exit(sig, frame)

    app = application(session, token, port, frozenset(hosts), addresses=not local)
    config = uvicorn.Config(
        app,
        log_level="warning",
        access_log=False,
        server_header=False,
        date_header=False,
        ws="none",
        # Requests and work under way share what time there is.
        timeout_graceful_shutdown=ceil(CLOSING_S),
    )
    try:
        # A limit holds for the whole process: entered and left by several threads of work it would
        # be lifted in between, and the last bits of a model hang on it.
        with one_blas_thread():
            Server(config).run(sockets=[listening])
    except KeyboardInterrupt:  # raised again once everything is shut down
        pass
    finally:
        session.close()
        listening.close()
    print("The workbench has ended.")


def _listening(host: str, port: int | None) -> socket.socket:
    if port is None:
        try:
            return _listening(host, PORT)
        except InvalidInputError:
            return _listening(host, 0)
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    # With the protocol said, asyncio sends at once what it has (TCP_NODELAY); else each answer
    # waits 40 ms for the browser to acknowledge its head.
    found = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    try:
        if os.name == "posix":  # elsewhere it would share the port with who has it
            found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        found.bind((host, port))
        found.listen(64)
    except OSError as error:
        found.close()
        why = error.strerror or error
        raise InvalidInputError(f"cannot listen on {host} port {port}: {why}; try --port") from None
    return found
