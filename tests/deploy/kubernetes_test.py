#!/usr/bin/env python3
"""deploy/kubernetes: kustomize builds it, Kubernetes' schemas and its parts agree, and the real server, nginx and
Prometheus take what it tells them.

    in_tools.sh kubernetes_test.py GEODESICD

No cluster runs here. So the Ingress controller is not run, but an nginx with the directives that its
annotations become, in front of three servers; prometheus-adapter is not run, but promtool reads its query
and the server has the metric. The server starts with the pod's arguments and environment, as root with its user,
and with the system calls that engines leave to a container without capabilities. For the bucket it has a folder.

GEODESICD_SEED=NUMBER sets what is drawn; it is printed.
"""

import json
import os
import pathlib
import random
import re
import secrets
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(HERE), str(HERE.parent / "crash"), str(HERE.parent / "cluster")]

import kubernetes_validate  # noqa: E402
import yaml  # noqa: E402
from confined import Confined, filters_of, works  # noqa: E402
from ingress import tells_nginx  # noqa: E402
from manifests import FOLDER, Pod, built, part  # noqa: E402
from ports import free_port  # noqa: E402
from service import Service  # noqa: E402

VERSIONS = ["1.27", "1.29", "1.31", "1.33", "1.35", "1.37"]
ADMIN_SECONDS = 1  # the admin's listener ends after the API's
failures = 0


def expect(what, is_so, *details):
    """Prints a line about one thing that must be so."""
    global failures
    failures += not is_so
    print(("ok: " if is_so else "FAILED: ") + what, *(() if is_so else details), flush=True)


def is_valid(documents):
    """Every document, by the schemas of several versions of Kubernetes, which know every name in it."""
    for document in documents:
        for version in VERSIONS:
            try:
                kubernetes_validate.validate(document, version, strict=True)
            except kubernetes_validate.ValidationError as error:
                expect(f"{document['kind']} is one of Kubernetes {version}", False, error.message)
    try:
        kubernetes_validate.validate({**documents[0], "nonsense": 1}, VERSIONS[-1], strict=True)
        expect("the schemas refuse nonsense", False)
    except kubernetes_validate.ValidationError:
        expect(f"{len(documents)} documents are valid in Kubernetes {', '.join(VERSIONS)}", not failures)
    listed = yaml.safe_load((FOLDER / "kustomization.yaml").read_text(encoding="utf-8"))["resources"]
    files = {file.name for file in FOLDER.glob("*.yaml")} - {"kustomization.yaml"}
    expect("the kustomization lists every file", set(listed) == files, listed, files)


def agree(documents, pod):
    """Labels, ports and names are the same wherever they stand."""
    kinds = {each["kind"]: each["spec"] for each in documents if "spec" in each}
    selectors = [pod.deployment["spec"]["selector"]["matchLabels"], kinds["Service"]["selector"],
                 kinds["PodDisruptionBudget"]["selector"]["matchLabels"],
                 kinds["NetworkPolicy"]["podSelector"]["matchLabels"],
                 *(each["labelSelector"]["matchLabels"] for each in pod.spec["topologySpreadConstraints"])]
    expect("all selectors find the pod", all(each and each.items() <= pod.labels.items() for each in selectors),
           selectors)
    [served] = kinds["Service"]["ports"]
    expect("the Service leads to the API", served["targetPort"] == "http" and served["port"] == pod.ports["http"],
           served)
    backend = kinds["Ingress"]["rules"][0]["http"]["paths"][0]["backend"]["service"]
    names = {each["kind"]: each["metadata"]["name"] for each in documents}
    expect("the Ingress leads to the Service", backend == {"name": names["Service"], "port": {"name": served["name"]}})
    policy = kinds["NetworkPolicy"]["ingress"]
    expect("the network lets exactly the pod's ports in",
           [each["port"] for rule in policy for each in rule["ports"]] == list(pod.ports), policy)
    target = kinds["HorizontalPodAutoscaler"]["scaleTargetRef"]
    expect("the autoscaler has the Deployment to itself", target["name"] == names["Deployment"]
           and "replicas" not in pod.deployment["spec"] and kinds["HorizontalPodAutoscaler"]["minReplicas"] >= 3)
    scraped = part("prometheus.yaml")["scrape_configs"][0]["relabel_configs"][0]
    expect("Prometheus looks for the pod's label and port", re.fullmatch(
        scraped["regex"], f"{pod.labels['app.kubernetes.io/name']};admin") and "admin" in pod.ports)
    namespaces = {each["metadata"].get("namespace", each["metadata"]["name"]) for each in documents}
    found = part("prometheus.yaml")["scrape_configs"][0]["kubernetes_sd_configs"][0]["namespaces"]["names"]
    expect("in its namespace", namespaces == set(found), namespaces, found)


def is_restricted(pod):
    """What the namespace asks of its pods, by Kubernetes' Pod Security Standards."""
    both = {**pod.spec["securityContext"], **pod.container["securityContext"]}
    expect("the pod keeps to the standard `restricted`",
           both["runAsNonRoot"] and both["seccompProfile"]["type"] == "RuntimeDefault"
           and both["capabilities"] == {"drop": ["ALL"]} and both["allowPrivilegeEscalation"] is False
           and both["readOnlyRootFilesystem"] and all("secret" in each or "emptyDir" in each for each in pod.spec["volumes"]), both)
    image = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    expect("its user is the image's", f"USER {both['runAsUser']}\n" in image)


def answers(port, path):
    """The status of a GET on this machine."""
    try:
        with urllib.request.urlopen(f"http://127.0.0.1:{port}{path}", timeout=20) as reply:
            return reply.status
    except urllib.error.HTTPError as error:
        return error.code


def tells_the_server(program, pod, folder, seed):
    """The server with the pod's arguments and environment."""
    made = subprocess.run([program, "--make-token", "test", "--scopes", "read,upload"], capture_output=True, text=True,
                          check=True).stdout.splitlines()
    profile = subprocess.run([ROOT / "scripts/fetch_seccomp_profile"], capture_output=True, text=True, check=True)
    confined = Confined("profile", profile.stdout.strip(), folder)
    tokens = confined.place("secret") / "tokens"
    tokens.write_text(made[1] + "\n", encoding="utf-8")
    tokens.chmod(0o644)
    environment = pod.environment("secret")
    mounted = {each["name"]: each["mountPath"] for each in pod.container["volumeMounts"]}
    expect("the tokens and prepared meshes are where their volumes are mounted",
           mounted == {"tokens": os.path.dirname(environment["GEODESICD_TOKENS"]),
                       "prepared": environment["GEODESICD_PREPARED"]}, mounted)
    environment["GEODESICD_PREPARED"] = str(confined.place("prepared"))
    environment["GEODESICD_TOKENS"] = str(tokens)
    arguments = pod.container["args"]
    clean = {name: value for name, value in os.environ.items() if not name.startswith("GEODESICD_")}
    said = subprocess.run([program, *arguments, "--check-config"], capture_output=True, text=True, check=False,
                          env={**clean, **environment})
    expect("the server takes the arguments and variables", said.returncode == 0, said.stderr)
    said = subprocess.run([program, *arguments, "--print-config"], capture_output=True, text=True, check=False,
                          env={**clean, **environment}).stdout
    settings = dict(re.findall(r'^(\S+) +"(.*)" +\S', said, re.M))
    unread = [name for name in environment
              if name.startswith("GEODESICD_") and not re.search(rf"\s{name}$", said, re.M)]
    expect("it reads each variable", not unread, unread)
    waits = int(settings["drain-delay-seconds"]) + int(settings["drain-seconds"]) + ADMIN_SECONDS
    expect("the pod may take as long as the server drains", pod.spec["terminationGracePeriodSeconds"] > waits, waits)
    ready = pod.container["readinessProbe"]
    expect("its probe sees that before the delay is over", int(settings["drain-delay-seconds"])
           > ready["periodSeconds"] * (ready["failureThreshold"] + 1), ready)

    environment["GEODESICD_STORE"] = str(confined.place("store"))
    at, ports = arguments.index("--listen"), {pod.ports["admin"]: free_port()}
    here = arguments[:at] + arguments[at + 2:]  # Service says where the API listens
    expect("the API listens at the pod's port", arguments[at + 1] == f"0.0.0.0:{pod.ports['http']}", arguments)
    here = [each.replace(f"0.0.0.0:{pod.ports['admin']}", f"127.0.0.1:{ports[pod.ports['admin']]}") for each in here]
    service = Service(confined.program(program), here, folder / "log", environment)
    ports[pod.ports["http"]] = service.port
    expect("the engine's filter holds for it", filters_of(service) == 1)
    expect("it decodes and computes", works(service, seed, {"Authorization": f"Bearer {made[0]}"}))
    expect("it asks for the token", service.ask("GET", "/v1/meshes")[0] == 401)
    for name, path, port in pod.probes():
        expect(f"{name} is answered 200", answers(ports[port], path) == 200)
    with urllib.request.urlopen(f"http://127.0.0.1:{ports[pod.ports['admin']]}/metrics", timeout=20) as reply:
        metrics = reply.read().decode()
    _, path, port = list(pod.probes())[-1]
    service.process.terminate()
    end = time.monotonic() + 20
    while answers(ports[port], path) == 200 and time.monotonic() < end:
        time.sleep(0.05)
    expect("told to stop, it says so to the probe", answers(ports[port], path) == 503)
    service.process.terminate()  # a second time: without the delay
    expect("and ends well", service.process.wait(60) == 0)
    return metrics


def has_metric(documents, pod, metrics, folder):
    """What the autoscaler asks for, through prometheus-adapter's rule, of the server's own metrics."""
    asked = next(each for each in documents if each["kind"] == "HorizontalPodAutoscaler")["spec"]["metrics"][0]["pods"]
    [rule] = part("prometheus_adapter.yaml")["rules"]["custom"]
    name = re.match(r"\w+", rule["seriesQuery"])[0]
    expect("the rule makes the metric that the autoscaler asks for",
           re.fullmatch(rule["name"]["matches"], name) and rule["name"]["as"] == asked["metric"]["name"], rule, asked)
    for query in ("seriesQuery", "metricsQuery"):
        labels = re.findall(r'(\w+)="(\w+)"', rule[query])
        series = [line for line in metrics.splitlines() if line.startswith(f"{name}{{")]
        expect(f"the server has what {query} asks for", labels and any(
            all(f'{label}="{value}"' in line for label, value in labels) for line in series), labels, series)
    query = rule["metricsQuery"]
    matchers = 'namespace="geodesicd",pod=~"a|b"'
    for template, value in (("Series", name), ("LabelMatchers", matchers), ("GroupBy", "pod")):
        query = query.replace(f"<<.{template}>>", value)
    rules = {"groups": [{"name": "queries", "rules": [{"record": "query", "expr": query},
                                                      {"record": "series", "expr": rule["seriesQuery"]}]}]}
    (folder / "rules.yml").write_text(yaml.safe_dump(rules), encoding="utf-8")
    tools = pathlib.Path(subprocess.run([ROOT / "scripts/fetch_prometheus"], capture_output=True, text=True,
                                        check=True).stdout.strip())
    said = subprocess.run([tools / "promtool", "check", "rules", folder / "rules.yml"], capture_output=True, text=True,
                          check=False)
    expect("Prometheus reads both queries", said.returncode == 0, said.stdout, said.stderr)

    # Debian's Prometheus cannot ask Kubernetes for pods: it is told of two ports of one, as Kubernetes tells of them.
    config = part("prometheus.yaml")
    [job] = config["scrape_configs"]
    expect("pods are asked for", job.pop("kubernetes_sd_configs")[0]["role"] == "pod")
    meta = "__meta_kubernetes_"
    job["static_configs"] = [{"targets": [f"10.0.0.1:{number}"], "labels": {
        f"{meta}namespace": "geodesicd", f"{meta}pod_name": "geodesicd-1", f"{meta}pod_container_port_name": name,
        f"{meta}pod_label_app_kubernetes_io_name": pod.labels["app.kubernetes.io/name"]}}
        for name, number in pod.ports.items()]
    (folder / "prometheus.yml").write_text(yaml.safe_dump(config), encoding="utf-8")
    said = subprocess.run([tools / "promtool", "check", "service-discovery", "--timeout=1s", folder / "prometheus.yml",
                           job["job_name"]], capture_output=True, text=True, check=False)
    targets = [each["labels"] for each in json.loads(said.stdout or "[]") if each.get("labels")]
    expect("Prometheus asks the admin's port, and says whose it is", [
        {name: each.get(name) for name in ("__address__", "job", "namespace", "pod")} for each in targets] == [
            {"__address__": f"10.0.0.1:{pod.ports['admin']}", "job": "geodesicd", "namespace": "geodesicd",
             "pod": "geodesicd-1"}], said.stdout, said.stderr)


def main():
    """The whole test."""
    program = os.path.abspath(sys.argv[1])
    seed = int(os.environ.get("GEODESICD_SEED") or secrets.randbelow(2**31))
    print(f"GEODESICD_SEED={seed}")
    documents = built()
    pod = Pod(documents)
    is_valid(documents)
    agree(documents, pod)
    is_restricted(pod)
    with tempfile.TemporaryDirectory(prefix="kubernetes_test_") as name:
        folder = pathlib.Path(name)
        metrics = tells_the_server(program, pod, folder, seed)
        has_metric(documents, pod, metrics, folder)
        tells_nginx(expect, program, documents, folder, random.Random(seed))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
