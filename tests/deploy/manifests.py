"""The files in deploy/kubernetes as kustomize builds them, and what a node would make of their pod."""

import pathlib
import subprocess

import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDER = ROOT / "deploy" / "kubernetes"


def built():
    """All documents, by the kustomize that kubectl has in it."""
    said = subprocess.run(["kubectl", "kustomize", FOLDER], capture_output=True, text=True, check=False)
    if said.returncode or said.stderr:
        raise RuntimeError(f"kubectl kustomize: {said.stderr}")
    return list(yaml.safe_load_all(said.stdout))


def part(name):
    """A file of what the cluster's own parts are told."""
    return yaml.safe_load((FOLDER / "cluster" / name).read_text(encoding="utf-8"))


class Pod:
    """The one container that the Deployment starts."""

    def __init__(self, documents):
        self.deployment = next(each for each in documents if each["kind"] == "Deployment")
        self.labels = self.deployment["spec"]["template"]["metadata"]["labels"]
        self.spec = self.deployment["spec"]["template"]["spec"]
        [self.container] = self.spec["containers"]
        self.ports = {each["name"]: each["containerPort"] for each in self.container["ports"]}
        self._maps = {each["metadata"]["name"]: each["data"] for each in documents if each["kind"] == "ConfigMap"}

    def environment(self, secret):
        """The variables of the process, where every key of a secret is `secret`."""
        found = {}
        for source in self.container["envFrom"]:
            found.update(self._maps[source["configMapRef"]["name"]])
        for each in self.container["env"]:
            source = each["valueFrom"]
            if "secretKeyRef" in source:
                found[each["name"]] = secret
            else:
                limit = source["resourceFieldRef"]["resource"].removeprefix("limits.")
                found[each["name"]] = self.container["resources"]["limits"][limit]
        return found

    def probes(self):
        """(name, path, port) of each probe."""
        for name in ("startupProbe", "livenessProbe", "readinessProbe"):
            asked = self.container[name]["httpGet"]
            yield name, asked["path"], self.ports[asked["port"]]
