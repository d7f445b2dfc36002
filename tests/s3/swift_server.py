#!/usr/bin/env python3
"""OpenStack Swift with its S3 interface, small enough for a test: a real object store.

    swift_server.py FOLDER      one proxy, account, container and object server on
                                127.0.0.1, with everything they write below FOLDER

Prints `listening on http://127.0.0.1:PORT` once it answers, and stops on SIGTERM.
Needs Debian's python3-swift (`scripts/setup s3`), and a folder whose file system has
user attributes, for Swift keeps its metadata there. The access key is `test:tester`,
the secret `testing`; the region is `us-east-1`. Its lists have pages of 5 keys,
where S3's have 1,000, so that a test of paging stays small.
"""

import os
import pathlib
import pwd
import signal
import subprocess
import sys
import time
import urllib.request

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "crash"))
from ports import free_port  # noqa: E402

STORAGE = ["account", "container", "object"]

COMMON = """
[DEFAULT]
swift_dir = {folder}
devices = {folder}/devices
mount_check = false
disable_fallocate = true
fallocate_reserve = 0
bind_ip = 127.0.0.1
bind_port = {port}
workers = 0
user = {user}
log_level = ERROR
"""

PROXY = """
[pipeline:main]
pipeline = catch_errors gatekeeper healthcheck cache listing_formats s3api tempauth copy slo dlo proxy-server

[app:proxy-server]
use = egg:swift#proxy
account_autocreate = true
allow_account_management = true
[filter:catch_errors]
use = egg:swift#catch_errors
[filter:gatekeeper]
use = egg:swift#gatekeeper
[filter:healthcheck]
use = egg:swift#healthcheck
[filter:cache]
use = egg:swift#memcache
# Nobody listens there: without a cache everything is asked anew, and is right.
memcache_servers = 127.0.0.1:1
[filter:listing_formats]
use = egg:swift#listing_formats
[filter:s3api]
use = egg:swift#s3api
location = us-east-1
# http://BUCKET.localhost:PORT/ as well as http://127.0.0.1:PORT/BUCKET/
storage_domain = localhost
max_bucket_listing = 5
[filter:tempauth]
use = egg:swift#tempauth
user_test_tester = testing .admin
[filter:copy]
use = egg:swift#copy
[filter:slo]
use = egg:swift#slo
[filter:dlo]
use = egg:swift#dlo
"""

BACKEND = """
[pipeline:main]
pipeline = {kind}-server
[app:{kind}-server]
use = egg:swift#{kind}
"""

# Each server is a process of its own: Swift patches the standard library of its own.
RUN = """
import os, sys
sys.argv = ["swift"]
from swift.common import utils
utils.SWIFT_CONF_FILE = {conf!r}
from swift.common import constraints
constraints.reload_constraints()
from swift.common.wsgi import run_wsgi
sys.exit(run_wsgi({path!r}, {name!r}, verbose=True))
"""


def write_rings(folder, ports):
    """One device, one replica: which is what a single machine has."""
    from swift.common.ring import RingBuilder

    for kind in STORAGE:
        builder = RingBuilder(4, 1, 0)
        device = {"region": 1, "zone": 1, "ip": "127.0.0.1", "port": ports[kind]}
        builder.add_dev({**device, "device": "sda", "weight": 1.0})
        builder.rebalance()
        builder.get_ring().save(str(folder / f"{kind}.ring.gz"))


def main():
    folder = pathlib.Path(sys.argv[1]).resolve()
    (folder / "devices" / "sda").mkdir(parents=True)
    conf = folder / "swift.conf"
    conf.write_text(
        "[swift-hash]\nswift_hash_path_suffix = test\n"
        "[storage-policy:0]\nname = one\ndefault = yes\n"
    )
    kinds = [*STORAGE, "proxy"]
    ports = {kind: free_port() for kind in kinds}
    user = pwd.getpwuid(os.getuid()).pw_name

    import swift.common.utils

    swift.common.utils.SWIFT_CONF_FILE = str(conf)
    write_rings(folder, ports)

    servers = []

    def stop(*_):
        for server in servers:
            server.kill()
        sys.exit(0)

    signal.signal(signal.SIGTERM, stop)

    for kind in kinds:
        text = PROXY if kind == "proxy" else BACKEND.format(kind=kind)
        path = folder / f"{kind}.conf"
        path.write_text(COMMON.format(folder=folder, port=ports[kind], user=user) + text)
        run = RUN.format(conf=str(conf), path=str(path), name=f"{kind}-server")
        with open(folder / f"{kind}.log", "wb") as log:
            servers.append(
                subprocess.Popen([sys.executable, "-c", run], stdout=log, stderr=log)
            )
    (folder / "proxy.pid").write_text(str(servers[-1].pid))

    url = f"http://127.0.0.1:{ports['proxy']}"
    opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
    for _ in range(300):
        try:
            with opener.open(f"{url}/healthcheck", timeout=5):
                break
        except OSError:
            if any(server.poll() is not None for server in servers):
                break
            time.sleep(0.1)
    else:
        stop()
    print(f"listening on {url}", flush=True)
    while all(server.poll() is None for server in servers):
        time.sleep(0.2)
    print("swift_server: a server ended by itself", file=sys.stderr)
    for server in servers:
        server.kill()
    return 1


if __name__ == "__main__":
    sys.exit(main())
