"""The doors of viser's server: its own page gets in, and nobody else."""

import http.client
from collections.abc import Iterator
from contextlib import closing

import pytest
import viser
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.frames import CloseCode
from websockets.sync.client import connect

from magicsim.live.server import LARGEST_BYTES, SHUT, close_server, open_server

PROTOCOL = f"viser-v{viser.__version__}"


@pytest.fixture(scope="module")
def server() -> Iterator[viser.ViserServer]:
    opened = open_server(8460, "test")
    yield opened
    close_server(opened)


def address(server: viser.ViserServer) -> str:
    return f"127.0.0.1:{server.get_port()}"


def fetched(server: viser.ViserServer, path: str, **headers: str) -> tuple[int, str | None]:
    with closing(http.client.HTTPConnection(address(server))) as connection:
        connection.request("GET", path, headers=headers)
        with connection.getresponse() as answer:
            answer.read()
            return answer.status, answer.headers["Content-Security-Policy"]


def test_listens_on_the_loopback_alone(server):
    assert server.get_host() == "127.0.0.1"


def test_page_is_served_with_its_policy_and_no_other_file(server):
    status, policy = fetched(server, "/")
    assert status == 200
    assert policy is not None
    assert "default-src 'self'" in policy
    for path in ("/../../_viser.py", "/%2e%2e/%2e%2e/_viser.py", "//proc/self/environ"):
        assert fetched(server, path)[0] == 404


def test_foreign_origin_is_refused_before_anything_is_sent(server):
    for origin in ("https://example.org", "null", None):
        with pytest.raises(InvalidStatus) as refused:
            connect(f"ws://{address(server)}", origin=origin, subprotocols=[PROTOCOL])
        assert refused.value.response.status_code == 403


def test_own_origin_is_connected(server):
    with connect(f"ws://{address(server)}", origin=f"http://{address(server)}", subprotocols=[PROTOCOL]) as own:
        assert len(own.recv(timeout=10)) > 0


def test_rebound_name_is_refused(server):
    assert fetched(server, "/", Host="attacker.example")[0] == 403


def test_tunnel_and_uploads_have_no_handler_on_server_or_client(server):
    assert not set(server._websock_server._incoming_handlers) & set(SHUT)
    with connect(f"ws://{address(server)}", origin=f"http://{address(server)}", subprotocols=[PROTOCOL]) as own:
        own.recv(timeout=10)
        clients = list(server.get_clients().values())
        assert all(not set(each._websock_connection._incoming_handlers) & set(SHUT) for each in clients)
        own.send(b"x" * (LARGEST_BYTES + 1))
        with pytest.raises(ConnectionClosed) as closed:
            listen(own)
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.code == CloseCode.MESSAGE_TOO_BIG


def listen(connection) -> None:
    while True:
        connection.recv(timeout=10)
