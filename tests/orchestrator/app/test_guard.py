"""Who gets in: foreign names of this machine, foreign pages, no token, files outside, floods."""

from __future__ import annotations

import socket
import subprocess
import sys
from collections.abc import Iterator
from http.client import HTTPConnection, HTTPResponse
from pathlib import Path
from typing import Any

import pytest

from orchestrator.cli.main import run

from .conftest import Served, served

#: The command in a process of its own.
APP = (sys.executable, "-c", "from orchestrator.cli import main; main()", "app")
SOCKET = "/_nicegui_ws/socket.io/?EIO=4&transport=websocket"
UPGRADE = {
    "Connection": "Upgrade",
    "Upgrade": "websocket",
    "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
}


def ask(
    server: Served,
    path: str,
    method: str = "GET",
    body: bytes | None = None,
    cookie: bool = True,
    **headers: str,
) -> tuple[HTTPResponse, bytes]:
    """Send a request as a client that knows nothing of rules; names of headers with underscores."""
    given = {name.replace("_", "-"): value for name, value in headers.items()}
    if cookie:
        given.setdefault("Cookie", f"tribofmu-{server.port}={server.token}")
    connection = HTTPConnection("127.0.0.1", server.port, timeout=20)
    connection.request(method, path, body, given)
    answer = connection.getresponse()
    # What follows a websocket's 101 has no end.
    text = b"" if answer.status == 101 else answer.read()
    connection.close()
    return answer, text


def upgrade(server: Served, cookie: bool = True, **headers: str) -> int:
    return ask(server, SOCKET, cookie=cookie, **UPGRADE, **headers)[0].status


def test_the_token_gives_a_cookie_that_scripts_and_other_sites_do_not_get(server: Served) -> None:
    answer, page = ask(server, f"/fmu?token={server.token}", cookie=False)
    kept = answer.getheader("set-cookie") or ""
    assert answer.status == 200 and b"url=/fmu" in page
    assert "HttpOnly" in kept and "SameSite=Strict" in kept and str(server.port) in kept
    opened, page = ask(server, "/", cookie=False, Cookie=kept.split(";")[0])
    assert opened.status == 200 and b"What is missing" in page


def test_the_welcome_leads_nowhere_else(server: Served) -> None:
    for path in ("//evil.example", "/%5cevil.example", "/\\evil.example"):
        _, page = ask(server, f"{path}?token={server.token}", cookie=False)
        assert b"url=//" not in page and b"url=/\\" not in page and b"url=" in page


@pytest.mark.parametrize(
    "path", ["/", "/fmu", "/files/project.yaml", "/page/reports/x.html", "/nowhere", "/favicon.ico"]
)
def test_nobody_gets_anything_without_the_token(server: Served, path: str) -> None:
    for more in ({}, {"Cookie": f"tribofmu-{server.port}=guess"}, {"Cookie": "tribofmu-1=x; =;;"}):
        answer, page = ask(server, path, cookie=False, **more)
        assert answer.status == 401
        assert b"hidden effect" not in page and server.token.encode() not in page
    assert ask(server, f"{path}?token=guess", cookie=False)[0].status == 401


@pytest.mark.parametrize(
    "host",
    ["evil.example", "evil.example:PORT", "127.0.0.1", "127.0.0.1:1", "127.0.0.1.evil.example:PORT", ""],
)
def test_another_name_of_this_machine_is_refused(server: Served, host: str) -> None:
    name = host.replace("PORT", str(server.port))
    assert ask(server, "/", Host=name)[0].status == 403
    assert upgrade(server, Host=name, Origin=f"http://{name}") == 403


def test_two_names_at_once_are_refused(server: Served) -> None:
    with socket.create_connection(("127.0.0.1", server.port), timeout=20) as line:
        own = f"Host: 127.0.0.1:{server.port}\r\n"
        cookie = f"Cookie: tribofmu-{server.port}={server.token}\r\n"
        line.sendall(f"GET / HTTP/1.1\r\n{own}Host: evil.example\r\n{cookie}\r\n".encode())
        assert b" 200 " not in line.recv(200)


def test_foreign_pages_are_refused_also_with_the_cookie(server: Served) -> None:
    own = f"http://127.0.0.1:{server.port}"
    for origin in (
        "http://evil.example",
        "null",
        f"http://localhost:{server.port}",
        f"https://127.0.0.1:{server.port}",
        own + "0",
    ):
        assert ask(server, "/", Origin=origin)[0].status == 403
        assert ask(server, "/_nicegui/client/1/upload/2", "POST", b"x", Origin=origin)[0].status == 403
        assert upgrade(server, Origin=origin) == 403
    assert (
        ask(server, "/", Sec_Fetch_Site="cross-site", Sec_Fetch_Mode="no-cors", Sec_Fetch_Dest="image")[
            0
        ].status
        == 403
    )
    assert ask(server, "/", Origin=own)[0].status == 200


def test_a_websocket_needs_its_own_page_and_the_cookie(server: Served) -> None:
    own = f"http://127.0.0.1:{server.port}"
    assert upgrade(server) == 403
    assert upgrade(server, cookie=False, Origin=own) == 403
    assert upgrade(server, Origin=own) == 101


@pytest.mark.parametrize(
    "path",
    [
        "../secret",
        "%2e%2e/secret",
        "data/..%2f..%2fsecret",
        "data/%2e%2e/%2e%2e/secret",
        "/etc/passwd",
        "%2fetc%2fpasswd",
        "away/passwd",
        "data/away.csv",
        ".workbench/lock",
        "data",
        "data%5c..%5csecret",
        "data/%00",
        "",
    ],
)
def test_only_files_of_the_project_are_handed_out(server: Served, path: str) -> None:
    (server.root.parent / "secret").write_text("told to nobody")
    for link, to in (("away", "/etc"), ("data/away.csv", "/etc/passwd")):
        if not (server.root / link).is_symlink():
            (server.root / link).symlink_to(to)
    for kind in ("files", "page"):
        answer, text = ask(server, f"/{kind}/{path}")
        assert answer.status in {404, 405, 200}
        assert b"told to nobody" not in text and b"root:" not in text
        assert answer.getheader("content-disposition") is None


def test_files_are_kept_not_opened_and_pages_can_do_nothing(server: Served) -> None:
    (server.root / "reports/bad.html").write_text("<script>top.location='http://evil.example'</script>")
    (server.root / "reports/b\u00fcch 1.html").write_text("x")
    answer, text = ask(server, "/files/project.yaml")
    assert text.startswith(b"format: 1")
    assert (answer.getheader("content-disposition") or "").startswith("attachment")
    assert answer.getheader("content-type") == "application/octet-stream"
    assert answer.getheader("x-content-type-options") == "nosniff"
    page, _ = ask(server, "/page/reports/bad.html")
    policy = page.getheader("content-security-policy") or ""
    assert page.status == 200
    assert "sandbox allow-scripts;" in policy and "default-src 'none'" in policy
    assert "allow-same-origin" not in policy and "allow-top-navigation" not in policy
    assert ask(server, "/page/project.yaml")[0].status == 404
    assert ask(server, "/files/reports/b%C3%BCch%201.html")[0].status == 200


def test_every_answer_forbids_what_is_foreign(server: Served) -> None:
    for path, cookie in (("/", True), ("/", False), ("/files/project.yaml", True), ("/nowhere", True)):
        answer, _ = ask(server, path, cookie=cookie)
        policy = answer.getheader("content-security-policy") or ""
        assert "default-src 'self'" in policy and "frame-ancestors 'none'" in policy
        assert "http" not in policy and "*" not in policy
        assert answer.getheader("referrer-policy") == "no-referrer"
        assert answer.getheader("access-control-allow-origin") is None


def test_a_page_names_no_foreign_address(server: Served) -> None:
    import re

    _, page = ask(server, "/")
    found = set(re.findall(rb"(?:src|href|url\(|import\()\s*=?\s*[\"']?(https?:)?//[^\"')\s]+", page))
    assert not found


def test_floods_are_cut_off(server: Served) -> None:
    own = f"http://127.0.0.1:{server.port}"
    announced = {
        "Content-Length": str(10**12),
        "Origin": own,
        "Content-Type": "multipart/form-data; boundary=x",
    }
    connection = HTTPConnection("127.0.0.1", server.port, timeout=20)
    connection.putrequest("POST", "/files/project.yaml")
    for name, value in {**announced, "Cookie": f"tribofmu-{server.port}={server.token}"}.items():
        connection.putheader(name, value)
    connection.endheaders()
    assert connection.getresponse().status == 413
    connection.close()
    assert ask(server, "/")[0].status == 200


def test_what_sends_more_than_it_announced_is_cut_off() -> None:
    """The guard alone, before an application that reads all it is given."""
    import asyncio

    from orchestrator.app.server.guard import Access, Guard

    access, got = Access(8420), []

    async def application(scope: Any, receive: Any, send: Any) -> None:
        while (message := await receive())["type"] == "http.request":
            got.append(len(message["body"]))

    async def flood() -> dict[str, str | bytes]:
        return {"type": "http.request" if len(got) < 50 else "http.disconnect", "body": b"x" * 1000}

    async def nothing(message: Any) -> None:
        pass

    headers = [(b"host", b"127.0.0.1:8420"), (b"cookie", f"tribofmu-8420={access.token}".encode())]
    scope = {
        "type": "http",
        "method": "POST",
        "path": "/",
        "scheme": "http",
        "query_string": b"",
        "headers": headers,
    }
    asyncio.run(Guard(application, access, largest=5000)(scope, flood, nothing))
    assert sum(got) == 5000


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A workbench that others on the network could reach."""
    folder = tmp_path_factory.mktemp("shared") / "project"
    yield from served(folder, "--host", "0.0.0.0", TRIBOFMU_APP_PASSWORD="a hall of presses")


def test_beyond_this_machine_the_password_opens(shared: Served) -> None:
    own = {"Origin": f"http://127.0.0.1:{shared.port}", "Content_Type": "application/x-www-form-urlencoded"}
    assert not shared.token
    answer, page = ask(shared, "/", cookie=False)
    assert answer.status == 401 and b'type="password"' in page and b"hidden effect" not in page
    assert ask(shared, "/?token=", cookie=False)[0].status == 401
    wrong, page = ask(shared, "/login", "POST", b"password=<script>", cookie=False, **own)
    assert wrong.status == 401 and b"not the password" in page and b"<script>" not in page
    assert ask(shared, "/login", "POST", b"password=", cookie=False, **own)[0].status == 401
    right, _ = ask(shared, "/login", "POST", b"password=a+hall+of+presses", cookie=False, **own)
    kept = (right.getheader("set-cookie") or "").split(";")[0]
    assert right.status == 200 and kept
    opened, page = ask(shared, "/", cookie=False, Cookie=kept)
    assert opened.status == 200 and b"hidden effect" in page
    assert ask(shared, "/", cookie=False, Cookie=kept, Host=f"evil.example:{shared.port}")[0].status == 403
    assert (
        ask(
            shared,
            "/login",
            "POST",
            b"password=a+hall+of+presses",
            cookie=False,
            Origin="http://evil.example",
        )[0].status
        == 403
    )


@pytest.mark.parametrize("password", ["", "short"])
def test_beyond_this_machine_a_password_is_demanded(tmp_path: Path, password: str) -> None:
    pytest.importorskip("nicegui", reason="the extra [app] is not installed")
    done = subprocess.run(
        [*APP, str(tmp_path / "new"), "--host", "0.0.0.0"],
        capture_output=True,
        text=True,
        env={"TRIBOFMU_APP_PASSWORD": password},
        timeout=60,
    )
    assert done.returncode == 2 and "TRIBOFMU_APP_PASSWORD" in done.stderr and "encrypted" in done.stderr
    assert not (tmp_path / "new").exists()


def test_without_the_extra_one_sentence_names_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert run(["app", str(tmp_path / "new")]) == 2
    assert "pip install 'tribofmu[app]'" in capsys.readouterr().err
    assert not (tmp_path / "new").exists()


def test_two_workbenches_do_not_share_a_project(server: Served) -> None:
    done = subprocess.run(
        [*APP, str(server.root), "--no-browser"], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 2 and "another workbench" in done.stderr


def test_a_port_that_is_taken_is_a_sentence(server: Served, tmp_path: Path) -> None:
    done = subprocess.run(
        [*APP, str(tmp_path / "new"), "--no-browser", "--port", str(server.port)],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert (
        done.returncode == 2 and f"--port {server.port}" in done.stderr and len(done.stderr.splitlines()) == 1
    )
