#!/usr/bin/env python3
"""The files in deploy/: a real Prometheus loads them, scrapes a real geodesicd, and
finds every metric that the alerts and the dashboard ask for.

    prometheus_test.py GEODESICD
"""

import json
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import urllib.parse
import urllib.request

HERE = pathlib.Path(__file__).resolve()
ROOT = HERE.parents[2]
sys.path.insert(0, str(ROOT / "tests" / "crash"))
from ports import free_port  # noqa: E402
from service import Service, mesh  # noqa: E402

DEPLOY = ROOT / "deploy"


def run(*command):
    """Runs a program, which must succeed."""
    print("$", *command, flush=True)
    subprocess.run([str(part) for part in command], check=True)


def names_in(expression):
    """The metrics that an expression of PromQL asks for."""
    return set(re.findall(r"\b(?:geodesicd|process)_[a-z0-9_]+", expression))


def dashboard_expressions():
    """Every query of the dashboard."""
    dashboard = json.loads((DEPLOY / "grafana" / "geodesicd.json").read_text())
    found = []

    def walk(node):
        if isinstance(node, dict):
            if isinstance(node.get("expr"), str):
                found.append(node["expr"])
            for value in node.values():
                walk(value)
        elif isinstance(node, list):
            for value in node:
                walk(value)

    walk(dashboard)
    return found


class Prometheus:
    """One that scrapes a port, with the rules of deploy/."""

    def __init__(self, program, target, folder):
        config = (DEPLOY / "prometheus" / "prometheus.yml").read_text()
        rules = DEPLOY / "prometheus" / "alerts.yml"
        config = config.replace("127.0.0.1:8081", f"127.0.0.1:{target}")
        config = config.replace("15s", "1s").replace("- alerts.yml", f"- {rules}")
        file = pathlib.Path(folder) / "prometheus.yml"
        file.write_text(config)
        self.url = f"http://127.0.0.1:{free_port()}"
        self.log = open(pathlib.Path(folder) / "log", "w+", encoding="utf-8")
        self.process = subprocess.Popen(
            [str(program), f"--config.file={file}", f"--storage.tsdb.path={folder}/data",
             f"--web.listen-address={self.url.removeprefix('http://')}"],
            stdout=self.log, stderr=self.log)

    def get(self, path):
        """The data of an answer of its API; None while it does not answer yet."""
        try:
            with urllib.request.urlopen(self.url + path, timeout=10) as reply:
                return json.load(reply)["data"]
        except OSError:
            return None

    def query(self, expression):
        """The series of an expression, now."""
        data = self.get("/api/v1/query?query=" + urllib.parse.quote(expression))
        return data["result"] if data else []

    def wait_for(self, what, condition):
        """Until the condition gives something true: that."""
        end = time.monotonic() + 60
        while time.monotonic() < end:
            if self.process.poll() is not None:
                break
            if found := condition():
                return found
            time.sleep(0.2)
        self.log.seek(0)
        print(self.log.read()[-3000:])
        raise AssertionError(f"Prometheus never had: {what}")

    def stop(self):
        """Its end."""
        self.process.terminate()
        self.process.wait(30)
        self.log.close()


def main():
    """The whole test."""
    program = sys.argv[1]
    tools = pathlib.Path(subprocess.run([ROOT / "scripts" / "fetch_prometheus"], check=True,
                                        capture_output=True, text=True).stdout.strip())
    run(tools / "promtool", "check", "config", DEPLOY / "prometheus" / "prometheus.yml")
    run(tools / "promtool", "test", "rules", DEPLOY / "prometheus" / "alerts_test.yml")

    with tempfile.TemporaryDirectory() as folder:
        service = Service(program, ["--store", f"{folder}/store", "--log-level", "warn"],
                          f"{folder}/geodesicd.log")
        try:
            status, _, body = service.ask("POST", "/v1/meshes", mesh(20, 1))
            assert status == 201, body
            base = "/v1/meshes/" + json.loads(body)["id"]
            for path in ("/distance?from=v:0", "/path?from=v:0&to=v:9", "/path?from=v:0&to=v:9999"):
                service.ask("GET", base + path)
            status, headers, text = service.ask("GET", "/metrics")
            assert status == 200, text
            assert headers["content-type"].startswith("text/plain; version=0.0.4"), headers
            lint = subprocess.run([tools / "promtool", "check", "metrics"], input=text,
                                  capture_output=True, check=False)
            assert lint.returncode == 0, lint.stderr.decode()

            prometheus = Prometheus(tools / "prometheus", service.port, folder)
            try:
                up = prometheus.wait_for("a target that is up",
                                         lambda: prometheus.query('up{job="geodesicd"} == 1'))
                assert len(up) == 1, up
                rules = prometheus.get("/api/v1/rules")["groups"]
                alerts = [rule for group in rules for rule in group["rules"]]
                assert len(alerts) >= 7, alerts
                prometheus.wait_for(
                    "all rules evaluated", lambda: all(
                        rule["health"] == "ok" for group in prometheus.get("/api/v1/rules")["groups"]
                        for rule in group["rules"]))
                expressions = dashboard_expressions()
                assert len(expressions) >= 10, expressions
                asked = set().union(*map(names_in, expressions + [r["query"] for r in alerts]))
                missing = {name for name in asked if not prometheus.query(name)}
                assert not missing, f"nobody exports {sorted(missing)}"
                served = prometheus.query(
                    'geodesicd_requests_total{route="/v1/meshes/{id}/path",status="422"}')
                assert served and float(served[0]["value"][1]) == 1, served
                print(f"{len(alerts)} alerts and {len(expressions)} queries of the dashboard ask "
                      f"for {len(asked)} metrics: all there")
            finally:
                prometheus.stop()
        finally:
            service.stop()


if __name__ == "__main__":
    main()
