"""Whether an outcome is what the contract's table of cases expects."""

from __future__ import annotations

import hashlib
import re
import struct
from typing import Any

import numpy as np
import pytest
from contract_calls import Outcome

import geodesicd


def check_error(error: geodesicd.GeodesicError, expect: dict[str, Any]) -> None:
    known = {"status", "code", "parameter", "limit", "actual", "retry_after", "id"}
    assert set(expect) <= known, "the table expects what this runner does not know"
    assert error.status == expect["status"]
    if "retry_after" in expect:
        assert error.retry_after is not None
    assert error.code == expect.get("code", error.code)
    assert error.request_id or error.status == 404  # HEAD has no body, but a header
    if "parameter" in expect:
        allowed = expect["parameter"]
        assert error.parameter in (allowed if isinstance(allowed, list) else [allowed])
    for name in ("limit", "actual"):
        if name in expect:
            assert getattr(error, name) == expect[name]
    assert error.code in str(error)


def check(outcome: Outcome, expect: dict[str, Any], tolerance: float) -> None:
    known = {"status", "json", "arrays", "bytes", "headers", "lines"}
    assert set(expect) <= known, "the table expects what this runner does not know"
    if outcome.status is not None and "status" in expect:
        assert outcome.status == expect["status"]
    for path, wanted in expect.get("json", {}).items():
        check_value(outcome.document, path, wanted, tolerance)
    for name, wanted in expect.get("arrays", {}).items():
        assert outcome.arrays is not None
        check_array(outcome.arrays[name], wanted, tolerance)
        if "max" in wanted:
            assert outcome.max == pytest.approx(wanted["max"], tolerance)
    if "bytes" in expect:
        assert outcome.data is not None
        check_bytes(outcome.data, outcome.media_type, expect["bytes"])
    for name, pattern in expect.get("headers", {}).items():
        assert re.search(pattern, outcome.headers[name]), outcome.headers
    if "lines" in expect:
        assert outcome.lines is not None
        assert len(outcome.lines) == len(expect["lines"])
        for line, wanted in zip(outcome.lines, expect["lines"], strict=True):
            assert line.status == wanted.get("status", 200)
            assert line.id == wanted.get("id")
            if line.error is not None:
                assert isinstance(line.error, geodesicd.GeodesicError)
                check_error(line.error, wanted)
            else:
                wanted = {k: v for k, v in wanted.items() if k != "id"}
                check(Outcome(line.reply), wanted, tolerance)


def found(document: Any, path: str) -> Any:
    """What is at ``points[0].xyz``. KeyError and IndexError: nothing is."""
    for step in re.findall(r"[^.\[\]]+", path):
        document = document[int(step)] if isinstance(document, list) else document[step]
    return document


def check_value(document: Any, path: str, wanted: Any, tolerance: float) -> None:
    if isinstance(wanted, dict) and wanted.get("absent"):
        with pytest.raises((KeyError, IndexError)):
            found(document, path)
        return
    value = found(document, path)
    if isinstance(wanted, dict):
        if "count" in wanted:
            assert len(value) == wanted["count"], path
        elif "between" in wanted:
            assert wanted["between"][0] <= value <= wanted["between"][1], path
        elif "matches" in wanted:
            assert re.search(wanted["matches"], value), path
        else:
            raise AssertionError(f"the table expects what this runner does not know: {wanted}")
    elif isinstance(wanted, list):
        assert len(value) == len(wanted), path
        for number, one in enumerate(wanted):
            check_value(value, f"[{number}]", one, tolerance)
    elif isinstance(wanted, float | int) and not isinstance(wanted, bool):
        assert value == pytest.approx(wanted, rel=tolerance, abs=tolerance), path
    else:
        assert value == wanted, path


def check_array(array: Any, wanted: dict[str, Any], tolerance: float) -> None:
    assert array.dtype == np.dtype(wanted["dtype"])
    assert list(array.shape) == wanted["shape"]
    flat = array.ravel()
    for index, value in wanted.get("values", {}).items():
        assert flat[int(index)] == pytest.approx(value, rel=tolerance, abs=tolerance)
    nothing = {"<u2": 65535, "<u4": 0xFFFFFFFF}.get(wanted["dtype"], np.inf)
    for index in wanted.get("unreached", []):
        assert flat[index] == nothing


def check_bytes(data: bytes, media_type: str | None, wanted: dict[str, Any]) -> None:
    known = {"begins", "media_type", "sha256", "png", "at_least"}
    assert set(wanted) <= known, "the table expects what this runner does not know"
    assert data.startswith(wanted.get("begins", "").encode())
    assert len(data) >= wanted.get("at_least", 0)
    if media_type is not None:
        assert media_type == wanted.get("media_type", media_type)
    if "sha256" in wanted:
        assert hashlib.sha256(data).hexdigest() == wanted["sha256"]
    if "png" in wanted:
        assert data.startswith(b"\x89PNG\r\n\x1a\n")
        assert list(struct.unpack(">II", data[16:24])) == wanted["png"]
