#!/usr/bin/env python3
"""nginx_test.py GEODESICD [COUNT]: what nginx refuses, the server refuses.

Sends raw requests to an nginx, which passes on what it takes to a stub, and to geodesicd: those
of a list, and COUNT mutations of good ones, drawn from a seed that is printed
(GEODESICD_SEED=NUMBER sets it). Where nginx answers 400 or another error, or closes without an
answer, geodesicd must answer by an error as well, or close. All requests ask for what there is,
so that a good one is answered 200.

It is one way only: geodesicd is the stricter one. Nor are two things compared, in which both are
free: how long a head may be, where each has limits of its own, and for how long one waits for
what is missing. Headers that newer versions of nginx want once only (User-Agent, Authorization
and others that say nothing of where a request ends) are in no request."""

import concurrent.futures
import os
import pathlib
import random
import socket
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / "crash"), str(ROOT / "tests" / "cluster")]

import nginx  # noqa: E402
from ports import free_port  # noqa: E402
from service import Service  # noqa: E402

COUNT = 2000
PATIENCE = 0.4  # seconds without an answer: it waits for more, and refuses nothing
LATE = 20  # seconds for an answer that must come

SITES = """
  server {{
    listen 127.0.0.1:{port};
    location / {{ proxy_pass http://unix:{folder}/stub:; }}
  }}
  server {{
    listen unix:{folder}/stub;
    location / {{ return 204; }}
  }}
"""


def head(line="GET /v1/methods HTTP/1.1", *headers, host="Host: x"):
    """A request of a line and some headers, without a body."""
    lines = [line, *([host] if host else []), *headers]
    return "".join(one + "\r\n" for one in lines).encode("latin-1") + b"\r\n"


def chunked(body, *headers):
    return head("GET /v1/methods HTTP/1.1", "Transfer-Encoding: chunked", *headers) + body


GOOD = [
    head(),
    head("GET /livez?a=b&c=%20 HTTP/1.1", "Accept: */*", "X-Thing:\tvalue \t"),
    head("HEAD /v1/methods HTTP/1.1", "Connection: close"),
    head("GET /v1/methods HTTP/1.0", host=None),
    head("GET http://example.org/v1/methods HTTP/1.1", host="Host: example.org"),
    head(host="Host: 127.0.0.1:8080"),
    head(host="Host: [::1]:8080"),
    head("GET /v1/methods HTTP/1.1", "Content-Length: 5") + b"hello",
    chunked(b"5\r\nhello\r\n0\r\n\r\n"),
    chunked(b"5;a=b\r\nhello\r\nA\r\n0123456789\r\n0\r\nTrailer: x\r\n\r\n"),
]

BAD = [
    *(head(host=f"Host: {name}") for name in (
        "", "a b", "a/b", "u@h", "[::1", "h:99999", "h:abc", "h:80:80", "<x>", "a,b", "a\\b",
        "a?b", "a#b", "%zz", "a..b", "..", ".", "[", "[]", "[::1]x", "a\tb", "a\x01b", "\x00",
        "http://h", "h:", ":80", "\xe9", "a;b", 'a"b', "::1", "a\x7fb")),
    *(head(f"GET {target} HTTP/1.1") for target in (
        "", "/%", "/%4", "/%zz", "/%00", "/..", "/../v1/methods", "/%2e%2e/x", "/v1/../../x",
        "v1/methods", "*", "http://", "http:///x", "http://u@h/", "http://h:abc/", "http://a b/",
        "http://[::1/", "http://h..h/", "/\x00", "/\x01", "/\x7f", "/a b", "/a\tb", "ftp://h/",
        "//h/../..", "http:/h", "://h/", "http://?", "http://h\\x/", "http://a_b/", "http://a~b/", "/#%")),
    *(line.encode("latin-1") + b"\r\nHost: x\r\n\r\n" for line in (
        "GET", "GET /", "GET  /v1/methods HTTP/1.1", "get /v1/methods HTTP/1.1",
        "GET /v1/methods HTTP/1.1 x", "GET /v1/methods HTTP/x.1", "GET /v1/methods http/1.1",
        "GET /v1/methods HTTP/1", "GET /v1/methods HTTP/11", "GET /v1/methods HTTP/2.0",
        "GET /v1/methods HTTP/0.9", "GET /v1/methods HTTP/1.1111", "G@T /v1/methods HTTP/1.1",
        "\x00GET /v1/methods HTTP/1.1", "GET\t/v1/methods HTTP/1.1", "CONNECT x:80 HTTP/1.1",
        "TRACE /v1/methods HTTP/1.1", "GET /v1/methods HTTP/1.1\r", "GET /v1/methods\x0bHTTP/1.1")),
    head(host=None), head("GET /v1/methods HTTP/1.1", "Host: y"),
    head(host="Host:\tx"), head(host="Host: x\t"),
    head("GET /v1/methods HTTP/1.1", "Content-Length:\t5") + b"hello",
    head("GET /v1/methods HTTP/1.1", "Transfer-Encoding:\tchunked") + b"0\r\n\r\n",
    *(head("GET /v1/methods HTTP/1.1", *lines) + b"4\r\nabcd\r\n0\r\n\r\n" for lines in (
        ["Content-Length: 4", "Transfer-Encoding: chunked"],
        ["Transfer-Encoding: chunked", "Content-Length: 4"],
        ["Content-Length: 4", "Content-Length: 5"], ["Content-Length: 4", "Content-Length: 4"],
        ["Content-Length: 4, 4"], ["Content-Length: +4"], ["Content-Length: -4"],
        ["Content-Length: 0x4"], ["Content-Length: 4 4"], ["Content-Length: "],
        ["Content-Length: 99999999999999999999999"], ["Content-Length: 9223372036854775808"],
        ["Content-Length : 4"], [" Content-Length: 4"], ["X: a", " folded"], ["X: a", "\tfolded"],
        ["X: a\x00b"], ["X\x00: a"], ["NoColon"], [": empty"], ["X Y: a"], ["X: a\rb"],
        ["Transfer-Encoding: chunked", "Transfer-Encoding: chunked"],
        ["Transfer-Encoding: gzip, chunked"], ["Transfer-Encoding: chunked, chunked"],
        ["Transfer-Encoding: identity"], ["Transfer-Encoding: xchunked"], ["Transfer-Encoding:"],
        ["Transfer-Encoding: \x0bchunked"], ["Transfer-Encoding : chunked"],
        ["Transfer-Encoding: chunked;q=1"], ['Transfer-Encoding: "chunked"'])),
    b"GET /v1/methods HTTP/1.0\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n",
    *(chunked(body) for body in (
        b"zz\r\nabc\r\n0\r\n\r\n", b"3\r\nabcd\r\n0\r\n\r\n", b"\r\n\r\n", b"3\r\nabc0\r\n\r\n",
        b"-3\r\nabc\r\n0\r\n\r\n", b"+3\r\nabc\r\n0\r\n\r\n", b"0x3\r\nabc\r\n0\r\n\r\n",
        b"3,3\r\nabc\r\n0\r\n\r\n", b" 3\r\nabc\r\n0\r\n\r\n", b"3\rabc\r\n0\r\n\r\n",
        b"fffffffffffffffff\r\nabc\r\n0\r\n\r\n", b"ffffffffffffffff\r\nabc\r\n0\r\n\r\n",
        b"3\r\nabc\r\n\r\n0\r\n\r\n", b"3\x00\r\nabc\r\n0\r\n\r\n", b";\r\nabc\r\n0\r\n\r\n",
        b"0\r\nno colon\r\n\r\n", b"0\r\nT: u\r\n folded\r\n\r\n", b"3\r\nabc\r0\r\n\r\n")),
    b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\r\n\r\n",
    b"\r\n\x00\r\n\r\n", b"SSH-2.0-x\r\n\r\n",
]  # fmt: skip

PIECES = [b"\r", b"\n", b"\r\n", b" ", b"\t", b"\0", b":", b"%", b"%2f", b"%00", b"/..", b"//",
          b",", b";", b"0x", b"+", b"-", b"\x80", b"\x7f", b"\x01", b"#", b"?", b"@", b"[", b"]",
          b"Content-Length: 3\r\n", b"Transfer-Encoding: chunked\r\n", b"Host: y\r\n",
          b"Connection: close\r\n", b"0\r\n", b"ffffffffffffffff", b"HTTP/1.0", b"HTTP/1.1"]  # fmt: skip


def mutated(request, chance):
    data = bytearray(request)
    for _ in range(chance.randint(1, 3)):
        at = chance.randrange(len(data) + 1)
        match chance.randrange(6):
            case 0:
                data[at : at + 1] = bytes([chance.randrange(256)])
            case 1:
                del data[at : at + chance.randint(1, 4)]
            case 2 | 3:
                data[at:at] = chance.choice(PIECES)
            case 4:
                data[at : at + 1] = chance.choice(PIECES)
            case _:  # a line twice, or in another place
                lines = bytes(data).split(b"\r\n")
                lines.insert(chance.randrange(len(lines) + 1), chance.choice(lines))
                data = bytearray(b"\r\n".join(lines))
    return bytes(data)


def outcome(port, request, patience):
    """The status of the answer; 0: closed without one; None: it waits for more."""
    with socket.create_connection(("127.0.0.1", port), timeout=LATE) as connection:
        answer = b""
        try:
            connection.sendall(request)
            connection.settimeout(patience)
            while b"\r\n" not in answer and len(answer) < 64:
                more = connection.recv(4096)
                if not more:
                    break
                answer += more
        except TimeoutError:
            return None
        except ConnectionError:  # reset, once it had answered or not
            pass
    words = answer.split(b" ", 2)
    if answer.startswith(b"HTTP/1.") and len(words) > 1 and words[1].isdigit():
        return int(words[1])
    return 0 if not answer else 200  # HTTP/0.9 has no status


def is_refusal(status):
    return status is not None and (status == 0 or status >= 400)


def start_nginx(program, folder):
    port = free_port()
    command = nginx.command(program, folder, SITES.format(folder=folder, port=port))
    with open(pathlib.Path(folder, "output"), "wb") as output:
        process = subprocess.Popen(command, stdout=output, stderr=output)
    end = time.monotonic() + 30
    while time.monotonic() < end and process.poll() is None:
        try:
            if outcome(port, head(), 5) == 204:
                return process, port
        except OSError:
            time.sleep(0.02)
    process.kill()
    raise RuntimeError(f"nginx did not start: {pathlib.Path(folder, 'output').read_text()}")


def main():
    program = sys.argv[1]
    count = int(sys.argv[2]) if len(sys.argv) > 2 else COUNT
    known = nginx.program("--known")
    if known is None:
        print("skipped: needs nginx (scripts/setup gets it)")
        return 77
    seed = int(os.environ.get("GEODESICD_SEED") or random.SystemRandom().randrange(1 << 31))
    print(f"GEODESICD_SEED={seed}", flush=True)
    chance = random.Random(seed)
    mutations = [mutated(chance.choice(GOOD), chance) for _ in range(count)]
    faults = []
    with tempfile.TemporaryDirectory() as folder:
        service = Service(program, ["--store", f"{folder}/store", "--log-level", "off"],
                          f"{folder}/log")  # fmt: skip
        process, port = start_nginx(known, folder)

        def compare(request):
            theirs = outcome(port, request, PATIENCE)
            if not is_refusal(theirs):
                return theirs, None
            # A head without an end is refused when its time is over, in 10 s: 408.
            if b"\r\n\r\n" not in request:
                return theirs, 408
            return theirs, outcome(service.port, request, LATE)

        try:
            for request in GOOD:
                if (statuses := (outcome(port, request, LATE), outcome(service.port, request, LATE))) \
                        != (204, 200):  # fmt: skip
                    faults.append(f"a good request: {statuses}: {request!r}")
            with concurrent.futures.ThreadPoolExecutor(16) as pool:
                found = list(pool.map(compare, [*BAD, *mutations]))
            alive = outcome(service.port, GOOD[0], LATE)
        finally:
            process.terminate()
            process.wait()
            service.process.kill()
    refused = sum(is_refusal(theirs) for theirs, _ in found)
    for request, (theirs, ours) in zip([*BAD, *mutations], found):
        if is_refusal(theirs) and not is_refusal(ours):
            faults.append(f"nginx says {theirs}, geodesicd {ours}: {request!r}")
    if alive != 200:
        faults.append(f"a good request at the end: {alive}")
    print(f"{len(found)} requests, of which nginx refused {refused}")
    if refused < len(BAD) // 2:
        faults.append("nginx refuses too little for this to mean anything")
    for fault in faults[:40]:
        print("FAILED:", fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
