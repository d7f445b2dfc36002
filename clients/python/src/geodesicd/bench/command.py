"""``geodesic bench``: the load test from a shell. Exit status 1: a limit was not kept."""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import json
import os
import signal
import sys
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.live import Live

from ..async_client import AsyncClient, AsyncMesh
from ..errors import GeodesicError
from ..flows import Retries
from .drive import Settings, drive
from .mixes import Workload, hills, parse_mix
from .records import Records
from .report import draw, failures, parse_limits, report
from .view import View

people = Console(stderr=True)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's arguments."""
    parser.add_argument("url", nargs="?", metavar="URL", help="the server; else $GEODESICD_URL")
    parser.add_argument("--token", help="else $GEODESICD_TOKEN")
    parser.add_argument(
        "--mix",
        default="path=8,field=1,table=1",
        metavar="SHARES",
        help="also of upload (%(default)s)",
    )
    loop = parser.add_mutually_exclusive_group()
    loop.add_argument("--clients", type=int, metavar="N", help="closed loop (4, without --rate)")
    loop.add_argument("--rate", type=float, metavar="N", help="open loop: N requests a second")
    parser.add_argument(
        "--seconds", type=float, default=30, metavar="N", help="how long (%(default)s)"
    )
    parser.add_argument("--ramp", type=float, default=0, metavar="SECONDS", help="grow that long")
    parser.add_argument(
        "--connections", type=int, default=64, metavar="N", help="open loop: at most (%(default)s)"
    )
    parser.add_argument(
        "--mesh", metavar="MESH", help="a file, a name or an id; else hills of --vertices"
    )
    parser.add_argument(
        "--vertices", type=int, default=20000, metavar="N", help="of the hills (%(default)s)"
    )
    parser.add_argument(
        "--sources", type=int, default=0, metavar="N", help="different sources; 0: any vertex"
    )
    parser.add_argument(
        "--table-side", type=int, default=8, metavar="N", help="rows and columns (%(default)s)"
    )
    parser.add_argument(
        "--method", metavar="NAME", help="auto, exact, …; else the server's default"
    )
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of chance (%(default)s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the report; -: print it")
    parser.add_argument("--picture", type=Path, metavar="FILE", help="draw it (.png, .svg, .pdf)")
    parser.add_argument("--fail-p99", metavar="MS", help="a limit, or by kind: path=50,field=200")
    parser.add_argument("--fail-errors", type=float, metavar="SHARE", help="a limit, 0 to 1")


def run(options: argparse.Namespace) -> int:
    """Runs the command; its exit status."""
    mix = parse_mix(options.mix)
    limits = None if options.fail_p99 is None else parse_limits(options.fail_p99)
    for kind in limits or {}:
        if kind != "all" and kind not in mix:
            raise ValueError(f"--fail-p99 names {kind}, which the mix has not")
    clients = options.clients if options.clients or options.rate else 4
    settings = Settings(options.seconds, clients, options.rate, options.ramp)
    records = Records()
    asyncio.run(_load(options, mix, settings, records))
    outcome = report(records, settings, mix)
    broken = failures(outcome, limits, options.fail_errors)
    outcome["failures"] = broken
    if options.json is not None:
        text = json.dumps(outcome, indent=2) + "\n"
        if str(options.json) == "-":
            sys.stdout.write(text)
        else:
            options.json.write_text(text, encoding="utf-8")
    if options.picture is not None:
        draw(records, outcome, options.picture)
    lag = records.lag.percentile(99)
    if settings.rate is not None and lag > 0.05:
        people.print(
            f"requests were sent up to {lag * 1000:.0f} ms late (99 %): this machine was too "
            "busy to send them, and latencies are too great by that",
            style="yellow",
        )
    for sentence in broken:
        people.print(f"geodesic: {sentence}", style="bold red", highlight=False, soft_wrap=True)
    return 1 if broken else 0


async def _load(
    options: argparse.Namespace, mix: dict[str, float], settings: Settings, records: Records
) -> None:
    connections = settings.clients or options.connections
    token = options.token or os.environ.get("GEODESICD_TOKEN")
    # Before and after the load refusals are waited out; in it they are counted.
    async with (
        AsyncClient(options.url, token=token) as patient,
        AsyncClient(
            options.url,
            token=token,
            retries=Retries(attempts=1),
            connections=connections,
            timeout=settings.seconds + settings.grace,
        ) as client,
    ):
        mesh = await (await _mesh(patient, options)).prepare()
        workload = Workload(
            mesh.id,
            mesh.vertices,
            mix,
            sources=options.sources,
            table_side=options.table_side,
            method=options.method,
            seed=options.seed,
        )
        stop = asyncio.Event()
        loop = asyncio.get_running_loop()
        loop.add_signal_handler(signal.SIGINT, stop.set)
        try:
            await _shown(drive(client, workload, settings, records, stop), records, settings, mix)
        finally:
            loop.remove_signal_handler(signal.SIGINT)
            for uploaded in workload.uploaded:
                # Those that were refused are not there; others may not be ours to delete.
                with contextlib.suppress(GeodesicError):
                    await patient.fetch("DELETE", f"/v1/meshes/{uploaded}")


async def _shown(load: Any, records: Records, settings: Settings, mix: dict[str, float]) -> None:
    view = View(records, settings, mix)
    if not people.is_terminal:  # a log needs the end only
        await load
        people.print(view)
        return
    with Live(view, console=people, refresh_per_second=4, auto_refresh=False) as live:
        running = asyncio.ensure_future(load)
        while not running.done():
            await asyncio.wait([running], timeout=0.25)
            live.update(view, refresh=True)
        await running


async def _mesh(client: AsyncClient, options: argparse.Namespace) -> AsyncMesh:
    if options.mesh is None:
        side = max(2, round(float(options.vertices) ** 0.5))
        return await client.upload(hills(side, 0))
    if Path(options.mesh).is_file():
        return await client.upload(Path(options.mesh))
    return await client.mesh(options.mesh)
