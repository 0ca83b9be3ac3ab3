"""The served report: it follows the files, answers questions, and refuses everybody else."""

from __future__ import annotations

import http.client
import json
import socket
import struct
import subprocess
import sys
import threading
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.editor.page_server import MOST_ASKED, PageServer
from mcpn.editor.served import ServedMission
from mcpn.study import open_study
from tests.commands import mcpn
from tests.conftest import ULYSSE
from tests.report.tabs import play_tokens, state, steps, visited

MISSION = """<mission name="{name}" xmlns="urn:mcpn:mission:1">
  <robot name="r"><hardware name="motor"/><activity name="go" consumes="motor"/></robot>
  <objective name="{leg}" activities="go"/>
</mission>
"""


@contextmanager
def serving(path: Path) -> Iterator[PageServer]:
    server = PageServer(ServedMission(path))
    thread = threading.Thread(target=server.run, daemon=True)
    thread.start()
    try:
        yield server
    finally:
        server.shutdown()
        thread.join(30)
        assert not thread.is_alive()


@pytest.fixture(scope="module")
def ulysse_served() -> Iterator[PageServer]:
    with serving(ULYSSE) as server:
        yield server


def asked(
    server: PageServer, method: str, path: str, body: bytes | str = b"", **headers: str
) -> tuple[int, str, dict[str, str]]:
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=30)
    named = {name.replace("_", "-"): value for name, value in headers.items()}
    connection.request(method, path, body or None, named)
    found = connection.getresponse()
    return found.status, found.read().decode(), dict(found.getheaders())


JSON = {"Content_Type": "application/json"}


def test_who_knows_the_address_is_answered(ulysse_served: PageServer) -> None:
    server = ulysse_served
    status, text, headers = asked(server, "GET", f"/{server.token}/")
    assert status == 200
    assert "May it go?" in text
    assert headers["Cache-Control"] == "no-store"
    assert "Access-Control-Allow-Origin" not in headers
    assert asked(server, "GET", f"/{server.token}/nothing")[0] == 404
    assert server.server_address[0] == "127.0.0.1"


def test_everybody_else_is_refused(ulysse_served: PageServer) -> None:
    server = ulysse_served
    good, port = f"/{server.token}/", server.server_port
    body = json.dumps({"formula": "EF success"}).encode()
    for path in ("/", "/x/", good[:-1], good[:-2] + "/", f"/{server.token}x/", f"/x{good}"):
        assert asked(server, "GET", path)[0] == 403
    for headers in (
        {"Origin": "https://example.org"},
        {"Origin": "null"},
        {"Origin": f"http://127.0.0.1:{port + 1}"},
        {"Host": f"evil.example:{port}"},  # a name that is made to lead here
        {"Sec_Fetch_Site": "cross-site"},
        {"Sec_Fetch_Site": "same-site"},
    ):
        assert asked(server, "GET", good, **headers)[0] == 403, headers
        assert asked(server, "POST", f"{good}ask", body, **JSON, **headers)[0] == 403, headers
    # A form of another page can send this without asking; a page of another origin cannot send JSON so.
    assert asked(server, "POST", f"{good}ask", body, Content_Type="text/plain")[0] == 403
    own = {"Origin": f"http://localhost:{port}", "Host": f"localhost:{port}", "Sec_Fetch_Site": "same-origin"}
    assert asked(server, "POST", f"{good}ask", body, **JSON, **own)[0] == 200
    for method in ("PUT", "DELETE", "OPTIONS"):
        assert asked(server, method, good)[0] == 501


def test_questions_have_the_answers_of_a_study(ulysse_served: PageServer) -> None:
    server, study = ulysse_served, open_study(ULYSSE)
    for formula in ("EF success", "AG EF (success | failure)", "AF success", "G !failure"):
        body = json.dumps({"formula": formula}).encode()
        status, text, _ = asked(server, "POST", f"/{server.token}/ask", body, **JSON)
        found = json.loads(text)
        answer = study.ctl(formula)
        assert status == 200
        assert found["holds"] == answer.holds
        assert [event for event, _ in found["steps"]] == [str(e) for e in answer.witness.run.events]
    wrong = json.dumps({"formula": "EF sucess"}).encode()
    assert "sucess" in json.loads(asked(server, "POST", f"/{server.token}/ask", wrong, **JSON)[1])["error"]


@given(
    st.one_of(st.binary(max_size=60), st.sampled_from([b"[]", b'{"formula": 1}', b"9" * (MOST_ASKED + 1)]))
)
def test_what_is_no_question_is_refused(ulysse_served: PageServer, body: bytes) -> None:
    status, _, _ = asked(ulysse_served, "POST", f"/{ulysse_served.token}/ask", body, **JSON)
    assert status == 400


@pytest.mark.parametrize("length", [f"{'0' * 9}{MOST_ASKED * 9}", "9" * 30, "-1", "1 ", "\u0661"])
def test_a_length_that_is_none_is_refused(ulysse_served: PageServer, length: str) -> None:
    """Zeros before a length do not make it a small one: nothing is read of such a request."""
    with socket.create_connection(("127.0.0.1", ulysse_served.server_port), 60) as client:
        head = [
            f"POST /{ulysse_served.token}/ask HTTP/1.1",
            f"Host: 127.0.0.1:{ulysse_served.server_port}",
            "Content-Type: application/json",
            f"Content-Length: {length}",
        ]
        client.sendall("\r\n".join([*head, "", ""]).encode())
        assert client.recv(4096).split()[1] == b"400"


def test_a_client_that_leaves_causes_no_traceback(
    ulysse_served: PageServer, capfd: pytest.CaptureFixture[str]
) -> None:
    """It asks for the page and resets the connection, again and again; the page is still served."""
    for _ in range(20):
        client = socket.create_connection(("127.0.0.1", ulysse_served.server_port), 60)
        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        host = f"127.0.0.1:{ulysse_served.server_port}"
        client.sendall(f"GET /{ulysse_served.token}/ HTTP/1.1\r\nHost: {host}\r\n\r\n".encode())
        client.close()
    assert asked(ulysse_served, "GET", f"/{ulysse_served.token}/")[0] == 200
    assert "Traceback" not in capfd.readouterr().err


def test_a_served_page_follows_an_edit(browser: Any, tmp_path: Path) -> None:
    """Also through an error, which it shows at its line; the run that is shown stays where it is possible."""
    path = tmp_path / "mission.xml"
    path.write_text(MISSION.format(name="first", leg="leg"))
    with serving(path) as server:
        tab, wrong = visited(browser, server.address)
        assert tab.locator("h1").inner_text() == "Mission first"
        tab.locator('#events button[data-event="MISSION_EV_START"]').click()
        path.write_text(MISSION.format(name="second", leg="leg"))
        tab.get_by_role("heading", name="Mission second").wait_for()
        assert state(tab) == "Running: leg."
        assert steps(tab) == ["MISSION_EV_START"]
        path.write_text(
            MISSION.format(name="third", leg="leg").replace('activities="go"', 'activities="gone"')
        )
        tab.locator(".problems").wait_for()
        assert f"{path}:3" in tab.locator(".problems").inner_text()
        assert 'activities="gone"' in tab.locator("pre .fails").inner_text()
        path.write_text(MISSION.format(name="<b>fourth</b>", leg="leg"))
        tab.locator(".problems", has_text="mission.xml:1").wait_for()
        other = tmp_path / "robot.xml"  # an import that is mended
        robot = '<robot name="q" xmlns="urn:mcpn:mission:1"><hardware name="arm"/>{}</robot>'
        other.write_text(robot.format("<hardware/>"))
        both = MISSION.format(name="both", leg="leg").replace("<robot", '<import href="robot.xml"/><robot')
        path.write_text(both)
        tab.locator(".problems", has_text="robot.xml:1").wait_for()
        other.write_text(robot.format(""))
        tab.get_by_role("heading", name="Mission both").wait_for()
        assert "arm" in tab.locator("#lost").inner_text()
        path.write_text(MISSION.format(name="fifth", leg="legs"))
        tab.get_by_role("heading", name="Mission fifth").wait_for()
        assert wrong == []
    tab.locator("#served-told", has_text="has ended").wait_for()


def test_a_question_is_typed_and_its_run_replayed(browser: Any, ulysse_served: PageServer) -> None:
    tab, wrong = visited(browser, ulysse_served.address)
    tab.locator("#formula").fill("EF (failure & oos(GPS_sensor))")
    tab.locator("#formula").press("Enter")
    tab.locator("#answered .holds").wait_for()
    tab.locator("#answered .replay").click()
    assert state(tab) == "The mission has ended in failure."
    tab.locator("#formula").fill("EF <b>x</b>")
    tab.locator("#ask button").click()
    tab.locator("#answered .missing").wait_for()
    assert tab.locator("#answered b").count() == 0
    assert wrong == []


def test_the_net_is_played_by_the_server(browser: Any, ulysse_served: PageServer) -> None:
    tab, wrong = visited(browser, ulysse_served.address)
    play_tokens(tab, open_study(ULYSSE).net, 1)
    assert wrong == []


@pytest.mark.parametrize(
    ("tokens", "transition", "why"),
    [
        ([], 0, "not enabled"),
        ([[0, 1]], 10_000, "not enabled"),
        ([[10_000, 1]], 0, "expected a place"),
        ([[-1, 1]], 0, "expected a place"),
        ([[0, -1]], 0, "expected a place"),
        (["x"], 0, "expected a place"),
    ],
)
def test_what_cannot_fire_is_told(
    ulysse_served: PageServer, tokens: list[Any], transition: int, why: str
) -> None:
    body = json.dumps({"tokens": tokens, "transition": transition})
    status, text, _ = asked(ulysse_served, "POST", f"/{ulysse_served.token}/fire", body, **JSON)
    assert status == 200
    assert why in json.loads(text)["error"]


def test_a_page_of_another_origin_learns_nothing(browser: Any, ulysse_served: PageServer) -> None:
    """Even where it knows the address, as the browser's own rules and the server's refuse it."""
    tab = browser.new_context().new_page()
    tab.route("https://example.org/", lambda route: route.fulfill(content_type="text/html", body="<p>hi"))
    tab.goto("https://example.org/")
    for options in ({}, {"method": "POST", "body": '{"formula": "EF success"}'}, {"mode": "no-cors"}):
        told = tab.evaluate(
            """async ([address, options]) => {
              try { const found = await fetch(address, options); return await found.text(); }
              catch { return ""; }
            }""",
            [ulysse_served.address, options],
        )
        assert "mission" not in told


def test_the_command(tmp_path: Path) -> None:
    gone = mcpn("serve", tmp_path / "none.xml")
    assert gone.returncode == 2
    assert "no such file" in gone.stderr
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        busy = mcpn("serve", ULYSSE, "--port", taken.getsockname()[1])
    assert busy.returncode == 2
    assert "cannot be listened on" in busy.stderr


def test_the_command_serves_until_it_is_ended() -> None:
    command = [sys.executable, "-m", "mcpn.cli", "serve", str(ULYSSE)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        address = process.stdout.readline().strip()
        with urllib.request.urlopen(address, timeout=30) as page:
            assert b"May it go?" in page.read()
        process.terminate()
        _, told = process.communicate(timeout=30)
    assert process.returncode == 143
    assert "Traceback" not in told
