import pytest

from magicsim.live.server import page_headers, refusal

PORT = 8321
SOCKET = {"Upgrade": "websocket"}


@pytest.mark.parametrize("name", ["127.0.0.1", "localhost"])
def test_own_page_is_answered(name: str):
    host = {"Host": f"{name}:{PORT}"}
    assert refusal(host, PORT) is None
    assert refusal(host | SOCKET | {"Origin": f"http://{name}:{PORT}"}, PORT) is None


@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": "https://example.org"},
        {"Origin": "null"},
        {"Origin": f"http://127.0.0.1:{PORT + 1}"},
        {"Origin": f"https://127.0.0.1:{PORT}"},
        SOCKET,
        SOCKET | {"origin": "http://localhost.example.org:8321"},
    ],
)
def test_foreign_origin_and_a_socket_without_one_are_refused(headers: dict[str, str]):
    assert refusal({"Host": f"127.0.0.1:{PORT}"} | headers, PORT) is not None


@pytest.mark.parametrize("host", ["example.org:8321", "127.0.0.1:80", "[::1]:8321", ""])
def test_another_name_of_this_machine_is_refused(host: str):
    assert refusal({"Host": host}, PORT) is not None
    assert refusal({}, PORT) is not None


def test_pages_fetch_nothing_from_elsewhere():
    policy = page_headers(PORT)["Content-Security-Policy"]
    assert "default-src 'self'" in policy
    assert "http:" not in policy
    assert "https:" not in policy
    assert "frame-ancestors 'none'" in policy
