"""The command ``geodesic`` in tests."""

from __future__ import annotations

import contextlib
import io
import os
import subprocess
import sys
from pathlib import Path
from unittest import mock

import geodesicd
from geodesicd.commands import main

PROGRAM = str(Path(sys.executable).parent / "geodesic")


def geodesic(
    server: geodesicd.LocalServer, *arguments: str | Path, status: int = 0
) -> subprocess.CompletedProcess[str]:
    """What the command prints and ends with, run in this process: to start Python and to import
    what the command needs takes longer than most of what it is asked."""
    out, err = io.StringIO(), io.StringIO()
    with (
        mock.patch.dict(os.environ, GEODESICD_URL=server.url),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        try:
            ended: object = main([str(argument) for argument in arguments])
        except SystemExit as left:  # argparse's way
            ended = 0 if left.code is None else left.code
    assert ended == status, err.getvalue()
    return subprocess.CompletedProcess(arguments, status, out.getvalue(), err.getvalue())


def installed(
    server: geodesicd.LocalServer, *arguments: str | Path, status: int = 0
) -> subprocess.CompletedProcess[str]:
    """The same of the program as it is installed."""
    run = subprocess.run(
        [PROGRAM, *arguments],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        env={**os.environ, "GEODESICD_URL": server.url},
    )
    assert run.returncode == status, run.stderr
    assert "Traceback" not in run.stderr
    return run
