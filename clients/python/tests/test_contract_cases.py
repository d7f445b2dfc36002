"""The contract's cases (tests/clients/contract_cases.json), each a test: every endpoint, format
and error through this client's own methods. Where a method gives NumPy instead of the contract's
JSON, both are asked for, and the one is checked against the other."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from contract_calls import QUERIES, Call
from contract_checks import check, check_error, found

import geodesicd

# Some rows are about them.
pytestmark = pytest.mark.filterwarnings("ignore::geodesicd.GeodesicWarning")

_TABLE = Path(__file__).parents[3] / "tests" / "clients" / "contract_cases.json"
TABLE: dict[str, Any] = json.loads(_TABLE.read_text(encoding="utf-8"))


class Servers:
    """A server for each name in the table, started when a case first needs it."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._running: dict[str, geodesicd.LocalServer] = {}

    def url(self, name: str) -> str:
        """Where the server of that name is."""
        if name not in self._running:
            wanted = TABLE["servers"][name]
            flags = [*wanted["flags"], "--log-level", "off"]
            if tokens := wanted.get("tokens"):
                file = self._folder / f"{name}.tokens"
                lines = [
                    f"{owner} {scopes} {hashlib.sha256(token.encode()).hexdigest()}\n"
                    for owner, (token, scopes) in tokens.items()
                ]
                file.write_text("".join(lines))
                file.chmod(0o600)
                flags += ["--tokens", str(file)]
            self._running[name] = geodesicd.serve(flags=flags)
            self._running[name].start()
        return self._running[name].url

    def stop(self) -> None:
        """Stops them all."""
        for server in self._running.values():
            server.stop()


@pytest.fixture(scope="module")
def servers(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Servers]:
    all_of_them = Servers(tmp_path_factory.mktemp("tokens"))
    yield all_of_them
    all_of_them.stop()


def connected(servers: Servers, case: dict[str, Any], token: str | None) -> geodesicd.Client:
    name = case.get("server", "plain")
    tokens = TABLE["servers"][name].get("tokens", {})
    return geodesicd.Client(
        servers.url(name),
        token=tokens[token][0] if token in tokens else None,
        retries=geodesicd.Retries(attempts=1),
    )


def bytes_of(mesh: str, samples: Path) -> bytes:
    if mesh in TABLE["meshes"]:
        text: str = TABLE["meshes"][mesh]["text"]
        return text.encode()
    return (samples / mesh).read_bytes()


@pytest.mark.parametrize("case", TABLE["cases"], ids=lambda case: case["name"])
def test_case(case: dict[str, Any], servers: Servers, samples: Path) -> None:
    subject = case.get("mesh")
    data = bytes_of(subject, samples) if isinstance(subject, str) else b""
    identity = subject["id"] if isinstance(subject, dict) else hashlib.sha256(data).hexdigest()
    steps = case.get("steps", [case])
    if isinstance(subject, str) and case.get("call") != "upload":
        with connected(servers, case, "admin") as client:
            client.upload(data)
    saved = {"mesh": identity}
    with connected(servers, case, case.get("token", "admin")) as client:
        for step in steps:
            arguments = filled(step.get("arguments", {}), saved)
            expect = step["expect"]
            call = Call(client, identity, data, job=bool(case.get("job") or step.get("job")))
            if "code" in expect or expect.get("status", 200) >= 400:
                check_refused(call, step["call"], arguments, expect)
                continue
            outcome = call.run(step["call"], arguments)
            check(outcome, expect, float(case.get("tolerance", 1e-9)))
            for name, where in step.get("save", {}).items():
                saved[name] = (
                    outcome.headers[where["header"]]
                    if "header" in where
                    else str(found(outcome.document, where["json"]))
                )


def filled(value: Any, saved: dict[str, str]) -> Any:
    """Arguments with what was saved in the place of {name}."""
    if isinstance(value, str):
        return re.sub(r"\{(\w+)\}", lambda m: saved.get(m[1], m[0]), value)
    if isinstance(value, list):
        return [filled(one, saved) for one in value]
    if isinstance(value, dict):
        return {name: filled(one, saved) for name, one in value.items()}
    return value


def check_refused(call: Call, name: str, arguments: dict[str, Any], expect: dict[str, Any]) -> None:
    with pytest.raises(geodesicd.GeodesicError) as caught:
        call.run(name, arguments)
    check_error(caught.value, expect)
    # The method of the query's name refuses it alike, but for tables, which it cuts.
    if (name, expect.get("code")) == ("table", "too_large"):
        return
    if name in QUERIES and not set(arguments) & {"format", "precision", "width", "view"}:
        with pytest.raises(geodesicd.GeodesicError) as caught:
            call.natural(name, dict(arguments))
        check_error(caught.value, expect)
