"""nginx and HAProxy in front of servers on this machine, as deploy/ configures them."""

import http.client
import re
import ssl
import subprocess
import time

import nginx
from nginx import ROOT, certificate
from ports import free_port
from service import reply_on

def adapted(file, changes):
    """The text of a file below deploy/, with patterns and what stands in their place here; each is found."""
    text = (ROOT / "deploy" / file).read_text(encoding="utf-8")
    for pattern, mine in changes:
        text, count = re.subn(pattern, mine, text)
        assert count, f"{file} has no {pattern}"
    return text


class Balancer:
    """A balancer that is started, asked and stopped. `checked`: what it says of its configuration.

    `changes` are further ones of its file: patterns, and what stands in their place.
    """

    name = ""
    shares = False  # whether it gives away what is about one mesh where its server is busy

    def __init__(self, folder, ports, changes=()):
        self.folder, self.port, self.changes = folder, free_port(), changes
        folder.mkdir()
        self.command, check = self.configure(ports)
        checked = subprocess.run(check, capture_output=True, text=True, check=False)
        self.checked = checked.stdout + checked.stderr
        self.is_well = checked.returncode == 0 and not re.search(r"\[warn|WARNING", self.checked)
        with open(folder / "said", "wb") as said:
            self.process = subprocess.Popen(self.command, stdout=said, stderr=said)
        self.trusting = ssl.create_default_context(cafile=folder / "cert")
        self.trusting.check_hostname = False
        for _ in range(200):
            try:
                if self.ask("GET", "/livez")[0] == 200:
                    return
            except OSError:
                pass
            time.sleep(0.1)
        raise TimeoutError(f"{self.name} does not answer: {(folder / 'said').read_text()}")

    def configure(self, ports):
        """Writes the configuration; the command that runs the balancer, and one that checks it."""
        raise NotImplementedError

    def ask(self, method, path, body=None, headers=None):
        """(status, headers in lower case, body) of one request on a connection of its own."""
        line = http.client.HTTPSConnection("127.0.0.1", self.port, context=self.trusting, timeout=40)
        return reply_on(line, method, path, body, headers)

    def stop(self):
        """Ends it."""
        self.process.terminate()
        self.process.wait(30)


def nginx_command(folder, port, changes):
    """Writes deploy/nginx/fleet.conf for this folder and port, changed; the command that runs nginx with it."""
    key, cert = certificate(folder)
    changes = [(r"listen 443 ssl", f"listen 127.0.0.1:{port} ssl"), (r"/etc/ssl/\S+\.pem", str(cert)),
               (r"/etc/ssl/\S+\.key", str(key)), (r"/var/cache/nginx/geodesicd", f"{folder}/cache"), *changes]
    (folder / "fleet.conf").write_text(adapted("nginx/fleet.conf", changes), encoding="utf-8")
    return nginx.command(nginx.program(), folder, f"  include {folder}/fleet.conf;")


class Nginx(Balancer):
    """deploy/nginx/fleet.conf."""

    name = "nginx"

    def configure(self, ports):
        servers = [(rf"10\.0\.0\.1{at}:8080", f"127.0.0.1:{port}") for at, port in enumerate(ports, 1)]
        command = nginx_command(self.folder, self.port, [*servers, *self.changes])
        return command, [*command, "-t"]


class HAProxy(Balancer):
    """deploy/haproxy/haproxy.cfg."""

    name = "HAProxy"
    shares = True

    def configure(self, ports):
        folder = self.folder
        key, cert = certificate(folder)
        both = folder / "both"
        both.write_text(cert.read_text() + key.read_text())
        changes = [(r"bind :443", f"bind 127.0.0.1:{self.port}"), (r"/etc/ssl/\S+\.pem", str(both))]
        changes += [(rf"10\.0\.0\.1{at}:8080", f"127.0.0.1:{port}") for at, port in enumerate(ports, 1)]
        changes += self.changes
        (folder / "haproxy.cfg").write_text(adapted("haproxy/haproxy.cfg", changes), encoding="utf-8")
        program = subprocess.run([ROOT / "scripts/fetch_haproxy"], capture_output=True, text=True, check=True).stdout.strip()
        return [program, "-f", folder / "haproxy.cfg"], [program, "-c", "-f", folder / "haproxy.cfg"]
