"""Real servers for the tests. The program and the sample meshes' maker are named by
$GEODESICD and $MAKE_SAMPLES, as tests/clients/python_test.sh does."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

import geodesicd


@pytest.fixture(scope="session")
def samples(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of sample meshes."""
    folder = tmp_path_factory.mktemp("samples")
    subprocess.run([os.environ["MAKE_SAMPLES"], str(folder)], check=True, stdout=subprocess.DEVNULL)
    return folder


@pytest.fixture(scope="session")
def server() -> Iterator[geodesicd.LocalServer]:
    """A server that all tests may use that do not harm it."""
    running = geodesicd.serve(flags=["--log-level", "warn"])
    running.start()
    yield running
    running.stop()


@pytest.fixture(scope="session")
def client(server: geodesicd.LocalServer) -> Iterator[geodesicd.Client]:
    """A client of that server."""
    with geodesicd.Client(server.url) as connected:
        yield connected


@pytest.fixture(scope="session")
def plane(client: geodesicd.Client, samples: Path) -> geodesicd.Mesh:
    """100 x 100 vertices at whole numbers in z = 0: its distances are Euclid's."""
    return client.upload(samples / "plane.glb")


@pytest.fixture(scope="session")
def holes(client: geodesicd.Client, samples: Path) -> geodesicd.Mesh:
    """A plane with three holes."""
    return client.upload(samples / "plane_three_holes.glb")


@pytest.fixture(scope="session")
def terrain(client: geodesicd.Client, samples: Path) -> geodesicd.Mesh:
    """180 x 180 vertices of hills, on which the exact method takes seconds."""
    return client.upload(samples / "terrain.glb")
