"""Who may talk to the window: a page that it served itself, on this machine, and nobody else.

A browser lets any page of any site open a websocket to 127.0.0.1 and tells its `Origin`; a name that is made to point
to 127.0.0.1 shows in `Host`. Both are checked before anything is answered.
"""

import http
from collections.abc import Mapping

HOST = "127.0.0.1"
"""The only address that is listened on."""
NAMES = (HOST, "localhost")
"""What a browser may call it."""


def refusal(headers: Mapping[str, str], port: int) -> str | None:
    """Why a request is refused; None where it is answered.

    Args:
        headers: Of the request, names in any case.
        port: That the server listens on.
    """
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

    Args:
        port: That the server listens on.
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


REFUSED = http.HTTPStatus.FORBIDDEN
"""Answer to a refused request."""
