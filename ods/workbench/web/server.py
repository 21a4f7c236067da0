"""The server of the workbench: NiceGUI on 127.0.0.1, behind the gate, with a WebSocket of its own for images."""

import logging
import socket
from collections.abc import Callable
from dataclasses import dataclass

import uvicorn
from fastapi import FastAPI, Request
from nicegui import core, ui
from starlette.middleware.trustedhost import TrustedHostMiddleware

from ods.base.errors import OdsError, one_line
from ods.workbench.session import Session
from ods.workbench.web import frames
from ods.workbench.web.ending import Server, stop_outboxes
from ods.workbench.web.limits import MOST_HEAD_BYTES, BoundedProtocol, not_a_strangers_fault
from ods.workbench.web.security import BROWSER, HOSTS, Gate

ADDRESS = HOSTS[0]
USUAL_PORT = 8420
"""Taken if it is free and no other was asked for."""
RECONNECT_S = 10.0
"""Time for which a page that lost its connection stays as it is, s; later it is built again, from its session."""
MOST_SENT = 1 << 20
"""Bytes of one message of a browser."""


class PortError(OdsError):
    """The port cannot be had."""


@dataclass(frozen=True)
class Site:
    """What the server shows."""

    build: Callable[[Session], None]
    """Makes the page, in NiceGUI's current slot."""
    new_session: Callable[[], Session]
    """For each browser one."""


def listening(port: int | None) -> socket.socket:
    """Return a socket that listens on 127.0.0.1; None: on the usual port, or any if it is taken. Raises PortError."""
    for number in (USUAL_PORT, 0) if port is None else (port,):
        bound = socket.socket()
        try:
            bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            bound.bind((ADDRESS, number))
            bound.listen()  # a browser that is quicker than the server waits
        except OSError as error:
            bound.close()
            why = error.strerror
        else:
            return bound
    raise PortError(f"port {port}: {why}")


def serve(site: Site, bound: socket.socket, issue: Callable[[str], None]) -> None:
    """Serve until interrupted. issue: gets each new link, the first one at once."""
    port = bound.getsockname()[1]
    gate = Gate(
        _application(site), f"ods-workbench-{port}", lambda token: issue(f"http://{ADDRESS}:{port}/?token={token}")
    )
    logging.getLogger("httpx").setLevel(logging.WARNING)
    logging.getLogger("nicegui").addFilter(in_one_line)
    logging.getLogger("uvicorn.error").addFilter(not_a_strangers_fault)
    config = uvicorn.Config(
        TrustedHostMiddleware(gate, HOSTS),
        log_config=None,
        log_level="warning",
        access_log=False,
        http=BoundedProtocol,
        h11_max_incomplete_event_size=MOST_HEAD_BYTES,
        ws_max_size=MOST_SENT,
        ws_per_message_deflate=False,  # nothing leaves the machine: packing would cost more than it saves
        timeout_graceful_shutdown=1,
    )
    Server(config).run(sockets=[bound])


def in_one_line(record: logging.LogRecord) -> bool:
    """Return whether NiceGUI's record of an error is logged, and make it one line: an OdsError is shown on its page."""
    error = record.exc_info[1] if record.exc_info else None
    if error is not None and not logging.getLogger(record.name).isEnabledFor(logging.DEBUG):
        record.msg, record.args, record.exc_info = f"{type(error).__name__}: {one_line(error)}", (), None
    return not isinstance(error, OdsError)


def _application(site: Site) -> FastAPI:
    """Return NiceGUI with one page, and the images' WebSocket beside it."""
    sessions: dict[str, Session] = {}

    @ui.page("/")
    def page(request: Request) -> None:
        browser = getattr(request.state, BROWSER)
        if browser not in sessions:
            sessions[browser] = site.new_session()
        site.build(sessions[browser])

    app = FastAPI(openapi_url=None)
    app.add_api_websocket_route("/frames", frames.pull)
    ui.run_with(
        app,
        title="ODS workbench",
        reconnect_timeout=RECONNECT_S,
        message_history_length=100,
        cache_control_directives="no-cache",
        show_welcome_message=False,
        gzip_middleware_factory=None,
    )
    core.app.on_shutdown(stop_outboxes)  # before NiceGUI cancels them
    core.sio.eio.cors_allowed_origins = None  # its own check of the Origin, which NiceGUI switches off
    return app
