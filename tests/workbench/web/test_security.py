"""Who the server answers: tokens, cookies, Host and Origin, against the server as it runs."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import httpx
import psutil
import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from ods.cli import main
from tests.workbench.serving import PROJECT, Serving, serving

SOCKET_IO = "/_nicegui_ws/socket.io/?EIO=4&transport="
PATHS = ("/", "/frames", "/static", "/_nicegui/3/static/x.js", f"{SOCKET_IO}polling", "/openapi.json", "/docs")


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Serving]:
    with serving(folder=tmp_path_factory.mktemp("empty")) as running:
        yield running


@pytest.fixture(scope="module")
def browser(server: Serving) -> Iterator[httpx.Client]:
    client = server.client()
    client.headers["x-next"] = server.line().partition(": ")[2].strip()  # the link that it printed then
    yield client
    client.close()


def cookie(browser: httpx.Client) -> str:
    ((name, value),) = browser.cookies.items()
    return f"{name}={value}"


def refused(url: str, **headers: str) -> int:
    """Return the status by which a WebSocket is refused; 101: it is not."""
    try:
        with connect(url.replace("http", "ws", 1), additional_headers=headers, compression=None, proxy=None):
            return 101
    except InvalidStatus as error:
        return error.response.status_code


@pytest.mark.parametrize("path", PATHS)
def test_without_a_cookie_there_is_one_line(browser: httpx.Client, server: Serving, path: str) -> None:
    answer = httpx.get(server.origin + path, trust_env=False)
    assert answer.status_code == 403
    assert answer.text.count("\n") == 1
    assert "cookie" not in answer.headers
    assert (
        httpx.get(server.origin + path, headers={"Cookie": 'x; y=; z"=1; ods-workbench=1'}, trust_env=False).status_code
        == 403
    )


def test_a_link_is_good_for_one_browser(browser: httpx.Client, server: Serving) -> None:
    again = httpx.get(server.link, trust_env=False)
    assert again.status_code == 403
    assert again.text.startswith("This link has been used: please open the newest one that")
    assert httpx.get(server.link + "x", trust_env=False).status_code == 403
    assert browser.get(server.link).status_code == 303  # that browser may come again by it
    first = browser.get("/")
    assert first.status_code == 200
    other = server.client(browser.headers["x-next"])
    assert other.get("/").status_code == 200
    assert cookie(other) != cookie(browser)


def test_the_cookie_is_for_this_server_only(server: Serving) -> None:
    link = server.line().partition(": ")[2].strip()
    reported = httpx.get(link, trust_env=False).headers["set-cookie"]
    server.line()
    assert "HttpOnly" in reported
    assert "SameSite=strict" in reported
    assert server.origin.rpartition(":")[2] in reported.partition("=")[0]  # two workbenches of one machine do not mix


def test_the_browser_is_reported_to_fetch_from_nowhere_else(browser: httpx.Client) -> None:
    page = browser.get("/")
    assert page.headers["content-security-policy"].startswith("default-src 'self'; ")
    assert "frame-ancestors 'none'" in page.headers["content-security-policy"]
    assert "https://" not in page.text


@pytest.mark.parametrize("path", PATHS)
def test_foreign_hosts_and_origins_are_refused_with_cookie(browser: httpx.Client, path: str) -> None:
    assert browser.get(path, headers={"Host": "evil.example"}).status_code == 400
    for origin in ("http://evil.example", "http://127.0.0.1:1", "null"):
        assert browser.get(path, headers={"Origin": origin}).status_code == 403


@pytest.mark.parametrize(
    "host", ["[::1]", "[::1]:8420", "[::ffff:127.0.0.1]", "[::1", "127.0.0.1.evil.example", "127.0.0.2", "", "evil:1:2"]
)
def test_no_other_name_is_answered_in_one_line(browser: httpx.Client, server: Serving, host: str) -> None:
    for headers in ({"Host": host}, {"Host": host, "Origin": f"http://{host}"}):
        answer = browser.get("/", headers=headers)
        assert answer.status_code == 400
        assert len(answer.text.splitlines()) == 1
    assert browser.get("/", headers={"Origin": f"http://{host}"}).status_code == 403


@pytest.mark.parametrize("token", ["x", "", "%00", "ä", "a&token=b", "x" * 9999])
def test_a_wrong_token_is_one_line(browser: httpx.Client, server: Serving, token: str) -> None:
    answer = httpx.get(f"{server.origin}/?token={token}", trust_env=False)
    assert answer.status_code == 403
    assert answer.text.count("\n") == 1
    assert "set-cookie" not in answer.headers


@pytest.mark.parametrize("path", ["/frames", f"{SOCKET_IO}websocket"])
def test_sockets_need_cookie_origin_and_host(browser: httpx.Client, server: Serving, path: str) -> None:
    url, own = server.origin + path, {"Cookie": cookie(browser), "Origin": server.origin}
    assert refused(url, **own) == 101
    assert refused(url, Origin=server.origin) == 403
    assert refused(url, Cookie=cookie(browser)) == 403
    assert refused(url, **{**own, "Origin": "http://evil.example"}) == 403
    assert refused(url, **{**own, "Origin": server.origin + "1"}) == 403
    # rebinding: a name of somebody else's that leads here
    named = {**own, "Host": "evil.example", "Origin": "http://evil.example"}
    assert browser.get(path, headers=named).status_code == 400


def test_socket_io_checks_the_origin_by_itself_too() -> None:
    program = """
import asyncio, httpx
from ods.workbench.session import Session
from ods.workbench.web import server
async def main():
    app = server._application(server.Site(lambda session: None, Session))
    client = httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://127.0.0.1:9")
    for origin in ("http://evil.example", "http://127.0.0.1:9"):
        answer = await client.get("/_nicegui_ws/socket.io/?EIO=4&transport=polling", headers={"Origin": origin})
        print(answer.status_code)
asyncio.run(main())
"""
    done = subprocess.run([sys.executable, "-c", program], cwd=PROJECT, capture_output=True, text=True)
    assert done.stdout.split() == ["400", "200"], done.stderr


def test_it_listens_on_this_machine_only_and_writes_nothing_here(browser: httpx.Client, server: Serving) -> None:
    process = psutil.Process(server.process.pid)
    listening = [held for held in process.net_connections() if held.status == psutil.CONN_LISTEN]
    assert [held.laddr.ip for held in listening] == ["127.0.0.1"]
    assert list(Path(process.cwd()).iterdir()) == []


@pytest.mark.parametrize("port", ["65536", "-1", "x", "1.5"])
def test_a_port_that_is_none_is_one_line(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["workbench", "--no-browser", "--port", port])
    reported = f"argument --port: {port!r} is not a port: 0 to 65535 (see ods workbench --help)"
    assert capsys.readouterr().err == f"ods workbench: {reported}\n"


def test_a_port_that_is_taken_is_one_line(server: Serving, capsys: pytest.CaptureFixture[str]) -> None:
    port = server.origin.rpartition(":")[2]
    assert main(["workbench", "--no-browser", "--port", port]) == 2
    assert capsys.readouterr().err == f"ods workbench: port {port}: Address already in use\n"
