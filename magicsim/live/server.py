"""viser's server, shut to everything but the window's own page: no other origin, no upload, no tunnel, no outside.

Measured of viser 1.1: it accepts a websocket of any origin, offers a public tunnel on request of a page, and takes
files for upload fields. None of these can be switched off by its settings.
"""

import contextlib
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from http import HTTPStatus
from typing import Any

import rich

from magicsim.errors import ConfigError

HOST = "127.0.0.1"
"""The only address that is listened on."""
NAMES = (HOST, "localhost")
"""What a browser may call it."""


def refusal(headers: Mapping[str, str], port: int) -> str | None:
    """Why a request is refused; None where it is answered."""
    told = {name.lower(): value for name, value in headers.items()}
    hosts = {f"{name}:{port}" for name in NAMES}
    if told.get("host") not in hosts:
        return "the window answers to 127.0.0.1 and localhost alone"
    origin = told.get("origin")
    is_socket = told.get("upgrade", "").lower() == "websocket"
    if (origin is None and is_socket) or (origin is not None and origin not in {f"http://{host}" for host in hosts}):
        return "the window talks to its own page alone"
    return None


def page_headers(port: int) -> dict[str, str]:
    """Headers of every page and script: nothing is fetched from elsewhere, and no other page may frame this one.

    viser's own script compiles a part of itself from text (a WebAssembly binding), so `unsafe-eval` has to stay.
    """
    sockets = " ".join(f"ws://{name}:{port}" for name in NAMES)
    policy = (
        "default-src 'self' data: blob:; script-src 'self' 'unsafe-inline' 'unsafe-eval' blob:; "
        f"style-src 'self' 'unsafe-inline'; connect-src 'self' data: blob: {sockets}; frame-ancestors 'none'; "
        "form-action 'none'; base-uri 'none'"
    )
    return {
        "Content-Security-Policy": policy,
        "Referrer-Policy": "no-referrer",
        "X-Content-Type-Options": "nosniff",
        "X-Frame-Options": "DENY",
    }


try:
    import viser
    from viser import _messages
    from websockets.asyncio import server as sockets
    from websockets.datastructures import Headers
    from websockets.http11 import Response
except ModuleNotFoundError as error:
    raise ConfigError(f"the live window needs {error.name}; `pip install magicsim[live]`") from error

LARGEST_BYTES = 1 << 16
"""Largest size of a message from the page [bytes]: a slider's is a few hundred."""
SHUT = (
    _messages.ShareUrlRequest,
    _messages.ShareUrlDisconnect,
    _messages.FileTransferStartUpload,
    _messages.FileTransferPart,
)
"""Messages of a page that nothing happens on."""


def open_server(port: int, title: str) -> viser.ViserServer:
    """A server on 127.0.0.1, whose websocket server is made with the checks of `refusal`."""
    original = sockets.serve

    def serve(*positional: Any, process_request: Any = None, **named: Any) -> Any:  # noqa: ANN401
        named |= {"max_size": LARGEST_BYTES}
        return original(*positional, process_request=_checked(process_request), **named)

    sockets.serve = serve  # type: ignore[assignment,misc]
    try:
        with _quiet():
            server = viser.ViserServer(host=HOST, port=port, label=title, verbose=False)
    finally:
        sockets.serve = original  # type: ignore[misc]
    _shut(server._websock_server)
    server._websock_server.on_client_connect(_shut)
    return server


def close_server(server: viser.ViserServer) -> None:
    """Stops listening; pages say that they have lost the connection."""
    with _quiet():
        server.stop()


def _shut(connection: Any) -> None:  # noqa: ANN401 -- viser's own, which has no public name
    for kind in SHUT:
        connection._incoming_handlers.pop(kind, None)


def _checked(answer: Any) -> Any:  # noqa: ANN401
    """A handler of requests that refuses the wrong ones, and gives every page its headers."""

    def process(connection: Any, request: Any) -> Any:  # noqa: ANN401
        port = connection.local_address[1]
        why = refusal(dict(request.headers.raw_items()), port)
        if why is not None:
            body = f"{why}\n".encode()
            head = Headers({"Content-Type": "text/plain; charset=utf-8", "Content-Length": str(len(body))})
            return Response(HTTPStatus.FORBIDDEN.value, HTTPStatus.FORBIDDEN.phrase, head, body)
        response = answer(connection, request) if answer is not None else None
        if response is not None:
            for name, value in page_headers(port).items():
                response.headers[name] = value
        return response

    return process


@contextmanager
def _quiet() -> Iterator[None]:
    """Within it, viser's banner is not printed, and its other lines go to stderr."""
    console = rich.get_console()
    before, console.quiet = console.quiet, True
    try:
        with contextlib.redirect_stdout(sys.stderr):
            yield
    finally:
        console.quiet = before
