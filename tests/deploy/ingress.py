"""deploy/kubernetes/ingress.yaml in front of three real servers, by a real nginx.

The Ingress controller is not run: the nginx here has the directives that the controller makes of the annotations.
"""

from balanced import ROOT, Balancer, directives, maps_of, shares_out
from manifests import part
from ports import free_port
from service import Service


def nginx_of(ingress, snippets, servers, port):
    """What the controller's nginx has in its http {…} by the annotations: directives of the same names."""
    said = {name.removeprefix("nginx.org/"): value for name, value in ingress["metadata"]["annotations"].items()}
    upstream = "\n".join(
        f"server 127.0.0.1:{each.port} max_fails={said['max-fails']} fail_timeout={said['fail-timeout']};"
        for each in servers)
    simple = "\n".join(f"{name.replace('-', '_')} {said[name]};" for name in (
        "client-max-body-size", "proxy-connect-timeout", "proxy-read-timeout", "proxy-send-timeout"))
    buffering = {"False": "off", "True": "on"}[said["proxy-buffering"]]
    return f"""{snippets}
upstream geodesicd {{ zone geodesicd 256k; {said['lb-method']}; {upstream} keepalive {said['keepalive']}; }}
server {{
  listen 127.0.0.1:{port};
  location / {{
    proxy_http_version 1.1;
    proxy_set_header Connection "";
    {said['location-snippets']}
    {simple}
    proxy_set_header Host $host;
    proxy_set_header X-Forwarded-For $proxy_add_x_forwarded_for;
    proxy_buffering {buffering};
    proxy_pass http://geodesicd;
  }}
}}"""


def tells_nginx(expect, program, documents, folder, random_):
    """The Ingress does what deploy/nginx/fleet.conf does."""
    ingress = next(each for each in documents if each["kind"] == "Ingress")
    snippets = part("nginx_ingress.yaml")["controller"]["config"]["entries"]["http-snippets"]
    flags = ["--trusted-proxies", "127.0.0.1", "--log-level", "warn"]
    servers = [Service(program, ["--store", f"{folder}/{at}", *flags], folder / "log") for at in range(3)]
    port = free_port()
    inside = nginx_of(ingress, snippets, servers, port)
    fleet = (ROOT / "deploy/nginx/fleet.conf").read_text(encoding="utf-8")
    expect("the key is that of fleet.conf", maps_of(snippets) == maps_of(fleet) and len(maps_of(fleet)) == 2)
    same = ("hash", "client_max_body_size", "proxy_next_upstream", "proxy_next_upstream_tries",
            "proxy_next_upstream_timeout", "proxy_connect_timeout", "proxy_read_timeout", "proxy_send_timeout",
            "proxy_set_header X-Request-Id", "proxy_set_header X-Forwarded-For", "proxy_http_version", "keepalive")
    for name in same:
        mine, theirs = directives(inside.replace(";", ";\n"), name), directives(fleet, name)
        expect(f"{name} is that of fleet.conf", mine and mine == theirs, mine, theirs)
    balancer = Balancer(folder / "nginx", inside, port)
    try:
        shares_out(expect, balancer, servers, random_)
    finally:
        balancer.stop()
        for server in servers:
            server.kill()
