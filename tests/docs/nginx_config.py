#!/usr/bin/env python3
"""nginx_config.py BUILD: deploy/nginx/geodesicd.conf in a real nginx with TLS before a real server.

nginx has to find it in order (`nginx -t`); then pages, redirects, an upload of more than 1 MB, a
query and the refusal of metrics go through it, below its prefix.
"""

import hashlib
import http.client
import json
import os
import pathlib
import re
import ssl
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / name) for name in ("contract", "cluster", "crash")]

import nginx  # noqa: E402
from ports import free_port  # noqa: E402
from server import Server  # noqa: E402

def main():
    """Configures, starts and asks."""
    build = pathlib.Path(sys.argv[1]).resolve()
    program = nginx.program()
    if program is None:
        print("skipped: there is no nginx")
        return 0 if os.environ.get("GEODESICD_OFFLINE") == "1" else 1
    failed = []
    with tempfile.TemporaryDirectory(prefix="nginx_") as name, \
            Server(build, "--docs", ROOT / "build/docs") as server:
        folder, port = pathlib.Path(name), free_port()
        key, cert = nginx.certificate(folder)
        ours = (ROOT / "deploy/nginx/geodesicd.conf").read_text(encoding="utf-8")
        for pattern, mine in ((r"listen 443 ssl", f"listen 127.0.0.1:{port} ssl"),
                              (r"/etc/ssl/\S+\.pem", str(cert)), (r"/etc/ssl/\S+\.key", str(key)),
                              (r"127\.0\.0\.1:8080", f"127.0.0.1:{server.port}")):
            ours, count = re.subn(pattern, mine, ours)
            assert count == 1, pattern
        (folder / "geodesicd.conf").write_text(ours, encoding="utf-8")
        command = nginx.command(program, folder, f"  include {folder}/geodesicd.conf;")
        tested = subprocess.run([*command, "-t"], capture_output=True, text=True, check=False)
        if tested.returncode or "[warn]" in tested.stderr:
            print(f"FAILED: nginx -t: {tested.stderr}")
            return 1
        process = subprocess.Popen(command)
        trusting = ssl.create_default_context(cafile=cert)
        trusting.check_hostname = False

        def ask(method, path, body=None):
            for _ in range(100):
                try:
                    line = http.client.HTTPSConnection("127.0.0.1", port, context=trusting, timeout=60)
                    line.request(method, path, body, {"Origin": f"https://127.0.0.1:{port}"})
                    reply = line.getresponse()
                    return reply.status, dict(reply.getheaders()), reply.read()
                except ConnectionRefusedError:
                    time.sleep(0.1)
            raise TimeoutError("nginx does not answer")

        def expect(what, found, wanted):
            if found != wanted:
                failed.append(f"{what}: {found!r} and not {wanted!r}")

        try:
            expect("the guide", ask("GET", "/geodesic/docs/")[0], 200)
            status, headers, _ = ask("GET", "/geodesic/docs")
            expect("without the slash", (status, headers.get("Location")), (308, "docs/"))
            expect("the API's page", ask("GET", "/geodesic/docs/api/")[0], 200)
            rows = "".join(f"v {i} {j} 0\n" for i in range(320) for j in range(320))
            mesh = (rows + "f 1 2 321\n" + "# padding\n" * 20000).encode()
            assert len(mesh) > 1 << 20
            status, _, body = ask("POST", "/geodesic/v1/meshes", mesh)
            expect("an upload by a page of its own origin", (status, json.loads(body).get("id")),
                   (201, hashlib.sha256(mesh).hexdigest()))
            target = f"/geodesic/v1/meshes/{hashlib.sha256(mesh).hexdigest()}/distance?from=v:0&at=v:1"
            expect("a query", json.loads(ask("GET", target)[2]).get("distances"), [1])
            for hidden in ("/geodesic/metrics", "/geodesic/debug/cache"):
                expect(hidden, ask("GET", hidden)[0], 404)
        finally:
            process.terminate()
            process.wait(30)
    for problem in failed:
        print(f"FAILED: {problem}")
    print(f"nginx before the server: {len(failed)} problems")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
