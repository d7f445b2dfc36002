"""The load test's mixes for Locust, which spreads over machines and has a page to watch. In a
clone of geodesicd, whose package is in no registry:

    pip install './clients/python[load]'
    locust -f clients/python/locustfile.py --host http://localhost:8080

$GEODESIC_MIX says the mix (``path=8,field=1,table=1`` without it), $GEODESIC_MESH the id of the
mesh that is asked about; without it, hills of 20,000 vertices are uploaded. Locust's users are a
closed loop; for an open one, where late replies hold up no request, see ``geodesic bench --rate``.
"""

from __future__ import annotations

import os
import random
import time
from typing import Any

from locust import User, constant, events, task

from geodesicd import Client, GeodesicError, Retries
from geodesicd.bench.mixes import Workload, hills, parse_mix


class MeshUser(User):
    """Asks about one mesh, a request after the other."""

    wait_time = constant(0)

    def on_start(self) -> None:
        """Connects, and uploads the mesh unless it is there."""
        self.client = Client(self.host, retries=Retries(attempts=1), connections=1)
        name = os.environ.get("GEODESIC_MESH")
        mesh = self.client.mesh(name) if name else self.client.upload(hills(141, 0))
        mix = parse_mix(os.environ.get("GEODESIC_MIX", "path=8,field=1,table=1"))
        self.workload = Workload(mesh.id, mesh.vertices, mix, seed=random.getrandbits(32))

    def on_stop(self) -> None:
        """Deletes what was uploaded, and closes the connection."""
        for mesh in self.workload.uploaded:
            try:
                self.client.fetch("DELETE", f"/v1/meshes/{mesh}")
            except GeodesicError:
                break  # refused: a token without that scope
        self.client.close()

    @task
    def ask(self) -> None:
        """One request of the mix."""
        kind, flow = self.workload.draw()
        start = time.perf_counter()
        error: Exception | None = None
        result: Any = None
        try:
            result = self.client.run(flow)
        except GeodesicError as refused:
            error = refused
        events.request.fire(  # type: ignore[no-untyped-call]
            request_type="geodesic",
            name=kind,
            response_time=(time.perf_counter() - start) * 1000,
            response_length=getattr(result, "nbytes", 0),
            exception=error,
            context={},
        )
