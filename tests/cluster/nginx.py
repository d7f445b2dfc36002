"""A real nginx for a test, whose files all lie in one folder."""

import os
import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[2]

MAIN = """
daemon off;
worker_processes 1;
pid {folder}/pid;
error_log {folder}/errors;
{user}
events {{ worker_connections 512; }}
http {{
  access_log off;
  client_body_temp_path {folder}/body;
  proxy_temp_path {folder}/proxy;
  fastcgi_temp_path {folder}/fastcgi;
  uwsgi_temp_path {folder}/uwsgi;
  scgi_temp_path {folder}/scgi;
{inside}
}}
"""


def program(*flags):
    """The nginx of this machine, or the one that scripts/fetch_nginx gets; None where there is none."""
    found = subprocess.run([ROOT / "scripts" / "fetch_nginx", *flags], capture_output=True, text=True, check=False)
    return found.stdout.strip() if found.returncode == 0 else None


def command(nginx, folder, inside):
    """Writes a configuration with `inside` in its http {…}; the command that runs it. With -t it is checked."""
    user = "user root;" if os.geteuid() == 0 else ""
    main = pathlib.Path(folder, "main")
    main.write_text(MAIN.format(folder=folder, user=user, inside=inside), encoding="utf-8")
    return [nginx, "-p", folder, "-e", f"{folder}/errors", "-c", main]


def certificate(folder):
    """A key and its certificate, which no authority has signed."""
    key, cert = pathlib.Path(folder, "key"), pathlib.Path(folder, "cert")
    subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "1", "-subj",
                    "/CN=geodesic.example.org", "-keyout", key, "-out", cert], check=True, capture_output=True)
    return key, cert
