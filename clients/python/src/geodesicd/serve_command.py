"""``geodesic serve``: a server on this machine, until Ctrl-C."""

from __future__ import annotations

import argparse
import signal
import sys
from pathlib import Path
from typing import Any

from .client import Client
from .command_line import sent
from .local_server import find_server, serve, shared_folder


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's arguments."""
    parser.add_argument(
        "file", nargs="*", type=Path, metavar="FILE", help="meshes to upload at the start"
    )
    parser.add_argument("--server", metavar="FILE", help="its program; else as installed")
    parser.add_argument(
        "--listen", default="127.0.0.1:8080", metavar="ADDRESS", help="HOST:PORT (%(default)s)"
    )
    parser.add_argument(
        "--store", type=Path, metavar="FOLDER", help="keep meshes there; else until it ends"
    )
    parser.add_argument("--samples", action="store_true", help="begin with sample meshes")


def run(options: argparse.Namespace) -> int:
    """Runs the command; its exit status."""
    program = find_server(options.server)
    flags = list(options.flags)
    for name in ("viewer", "docs", *(["samples"] if options.samples else [])):
        folder = shared_folder(program, name)
        if folder is None and name == "samples":
            raise ValueError(f"no sample meshes came with {program}; name files of your own")
        if folder is not None and not any(flag.split("=")[0] == f"--{name}" for flag in flags):
            flags += [f"--{name}", str(folder)]
    server = serve(program, store=options.store, listen=options.listen, flags=flags)

    def interrupt(number: int, frame: Any) -> None:
        raise KeyboardInterrupt

    # Whoever stops this process wants the server to stop with it.
    signal.signal(signal.SIGTERM, interrupt)
    signal.signal(signal.SIGINT, interrupt)
    try:
        url = server.start()
        with Client(url) as client:
            for file in options.file:
                print(f"{sent(client, file).id}  {file}", file=sys.stderr)
        print(f"listening on {url}", flush=True)
        return server.wait()
    finally:
        server.stop()
