"""What the server remarks on an answer (``Geo-Warnings``), such as a point far from the surface, is
a warning at the caller's line, and a sentence of the command's."""

from __future__ import annotations

import asyncio
import inspect
import re
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import geodesic

import geodesicd
from geodesicd.plot import plot
from geodesicd.remarks import remark, remarks_in

FAR = (50.0, 50.0, 40.0)
SENTENCE = r"(The|1 of \d) points? of \w+ is 40 away from the surface, more than .*max_snap"


ASKING: dict[str, Callable[[geodesicd.Mesh, Any], Any]] = {
    "distance": lambda mesh, point: mesh.distance([point]),
    "float32": lambda mesh, point: mesh.distance([point], dtype=np.float32),
    "labels": lambda mesh, point: mesh.distance([point, 3], labels=True),
    "distance_at": lambda mesh, point: mesh.distance_at(point, [1]),
    "path": lambda mesh, point: mesh.path(point, 5),
    "table": lambda mesh, point: mesh.table([point], [1]),
    "isolines": lambda mesh, point: mesh.isolines([point], count=2),
    "samples": lambda mesh, point: mesh.samples(3, covered=[point]),
    "trace": lambda mesh, point: mesh.trace(point, 5, direction=(1, 0, 0)),
    "measure": lambda mesh, point: mesh.measure([point], [1, 2]),
    "voronoi": lambda mesh, point: mesh.voronoi([point, 0]),
    "loop": lambda mesh, point: mesh.loop(through=[point, 1, 2]),
    "logmap": lambda mesh, point: mesh.logmap(point, 3),
    "query": lambda mesh, point: mesh.query("distance", {"from": point}, format="u16"),
    "picture": lambda mesh, point: mesh.picture([point]),
    "job": lambda mesh, point: mesh.path(point, 5, progress=lambda part: None),
    "plot": lambda mesh, point: plot(mesh, point, size=(2, 2), dpi=40, isolines=2),
}


@pytest.mark.parametrize("asking", ASKING)
def test_a_remark_is_a_warning_at_the_callers_line(plane: geodesicd.Mesh, asking: str) -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        # What other tests have left to the collector is no remark.
        warnings.simplefilter("ignore", ResourceWarning)
        ASKING[asking](plane, FAR)
    assert caught
    _, line = inspect.getsourcelines(ASKING[asking])
    for one in caught:
        assert one.category is geodesicd.GeodesicWarning
        assert re.match(SENTENCE, str(one.message))
        assert (one.filename, one.lineno) == (__file__, line)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ASKING[asking](plane, 0)  # of a vertex there is nothing to remark
        if asking != "plot":
            ASKING[asking](plane, geodesicd.Xyz(FAR, max_snap=50))  # nor of what was meant


def line_here() -> int:
    frame = inspect.currentframe()
    assert frame is not None
    assert frame.f_back is not None
    return frame.f_back.f_lineno


def test_a_line_of_many_is_named(plane: geodesicd.Mesh) -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        warnings.simplefilter("ignore", ResourceWarning)  # of other tests
        paths, line = plane.paths([(0, 1), (FAR, 2)]), line_here()
        plane.batch([{"query": "path", "from": FAR, "to": 4}] * 40 + [{"query": "nothing"}])
    assert paths[1].length > 0
    told = [str(one.message) for one in caught]
    assert re.match(r"pairs\[1\]: The point of from is 40 away", told[0])
    assert (caught[0].filename, caught[0].lineno) == (__file__, line)
    # Many are cut, so that they do not hide everything else.
    assert told[1].startswith("queries[0]: The point")
    assert told[-1] == "and 30 more warnings"
    assert len(told) == 1 + 10 + 1


def test_asynchronously(plane: geodesicd.Mesh) -> None:
    async def ask() -> int:
        async with geodesicd.AsyncClient(plane.client.url) as client:
            mesh = await client.mesh(plane.id)
            field, line = await mesh.distance(FAR), line_here()
            assert len(field) == 10000
            # A task has no caller of ours: the line that runs the loop is named.
            await asyncio.gather(mesh.path(FAR, 1))
            return line

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        warnings.simplefilter("ignore", ResourceWarning)  # of other tests
        line, here = asyncio.run(ask()), line_here()
    assert [one.lineno for one in caught] == [line, here]
    assert {one.filename for one in caught} == {__file__}


def test_a_remark_can_be_an_error(plane: geodesicd.Mesh) -> None:
    before = plane.client.status()["jobs"]["ended"]
    with warnings.catch_warnings():
        warnings.simplefilter("error", geodesicd.GeodesicWarning)
        with pytest.raises(geodesicd.GeodesicWarning, match="5 %"):
            plane.path(FAR, 5, progress=lambda part: None)
        plane.path(0, 5)
    assert plane.client.status()["jobs"]["ended"] == before  # none is left lying about


def test_the_command_tells_each_once(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh, tmp_path: Path
) -> None:
    point = "p:" + ",".join(map(str, FAR))
    for command in (
        ("distance", plane.id, "--from", point, "--at", "5"),
        ("path", plane.id, "--from", point, "--to", "5"),
        ("plot", plane.id, "--from", point, "-o", tmp_path / "f.png"),
    ):
        run = geodesic(server, *command)
        told = [line for line in run.stderr.splitlines() if "warning" in line]
        assert len(told) == 1
        assert re.match(f"geodesic: warning: {SENTENCE.removesuffix('max_snap')}", told[0])
        assert "max_snap" not in run.stderr  # which the command has not
        assert "away" not in run.stdout


def test_what_a_header_says() -> None:
    assert remarks_in({}) == []
    assert remarks_in({"geo-warnings": "one; two"}) == ["one", "two"]
    assert remarks_in({"geo-warnings": " ; ; a;b;"}) == ["a;b;"]


def test_no_sentence_steers_a_terminal_or_floods_it() -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        warnings.simplefilter("ignore", ResourceWarning)  # of other tests
        remark(["a\x1b[2Jb", "x" * 10**6, "a\x1b[2Jb"])
    assert [str(one.message) for one in caught] == ["a?[2Jb", "x" * 1000]
    assert "\x1b" not in str(geodesicd.GeodesicError(500, "internal", "\x1b[2J"))
