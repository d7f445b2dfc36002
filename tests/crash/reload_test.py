#!/usr/bin/env python3
"""A real process and a real SIGHUP: settings and tokens are read again, or all of the
old ones stay; and what --check-config and --make-token say and exit with.

    reload_test.py GEODESICD
"""

import http.client
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time

from service import Service, mesh

failures = 0


def expect(what, is_so, *details):
    """Prints a line about one thing that must be so."""
    global failures
    failures += not is_so
    print(("ok: " if is_so else "FAILED: ") + what, *(() if is_so else details))


def run(program, *flags):
    """(exit status, standard output, standard error) of a command that ends by itself."""
    clean = {k: v for k, v in os.environ.items() if not k.startswith("GEODESICD_")}
    done = subprocess.run([program, *flags], capture_output=True, text=True, env=clean, timeout=60)
    return done.returncode, done.stdout, done.stderr


def fresh_token(program, name, scopes):
    """A token, and the line of the file that lets it in."""
    status, out, _ = run(program, "--make-token", name, "--scopes", scopes)
    secret, line = out.splitlines()
    expect(f"--make-token makes one for {name}", status == 0 and secret.startswith("geo_"))
    return secret, line


class Running:
    """The process, its files, and what it logs."""

    def __init__(self, program, folder):
        self.folder = folder
        self.config({})
        flags = ["--config", str(folder / "config.json"), "--store", str(folder / "store")]
        self.service = Service(program, flags, folder / "errors")
        self.lines = []
        self._listener = threading.Thread(target=self._listen, daemon=True)
        self._listener.start()

    def _listen(self):
        for line in self.service.process.stdout:
            self.lines.append(line.decode())

    def config(self, options):
        (self.folder / "config.json").write_text(json.dumps(options))

    def tokens(self, *lines):
        path = self.folder / "tokens"
        path.write_text("# who may do what\n" + "\n".join(lines) + "\n")
        path.chmod(0o600)
        return str(path)

    def hang_up(self):
        """Sends SIGHUP and waits for what the log says of it, up to the line that ends it."""
        before = len(self.lines)
        self.service.process.send_signal(signal.SIGHUP)
        for _ in range(600):
            said = "".join(self.lines[before:])
            if re.search("reload: (done|nothing was changed)", said):
                return said
            time.sleep(0.1)
        raise RuntimeError("SIGHUP did nothing")

    def stop(self):
        """SIGTERM, and all that is logged until the end; the exit status."""
        self.service.process.terminate()
        self._listener.join(60)
        return self.service.stop()

    def status(self, method="GET", path="/v1/status", token=None, body=None):
        """(HTTP status, body) of a request with a token."""
        connection = http.client.HTTPConnection("127.0.0.1", self.service.port, timeout=60)
        headers = {"Authorization": f"Bearer {token}"} if token else {}
        connection.request(method, path, body, headers)
        reply = connection.getresponse()
        text = reply.read()
        connection.close()
        return reply.status, text


def reloads(program, folder):
    """One process through good and bad reloads."""
    reader, reader_line = fresh_token(program, "reader", "read")
    uploader, uploader_line = fresh_token(program, "uploader", "upload")
    running = Running(program, folder)
    expect("without tokens everybody may read", running.status()[0] == 200)

    options = {"tokens": running.tokens(reader_line), "max-json-bytes": 1234}
    running.config(options)
    said = running.hang_up()
    expect("the log names what changed", "changed: tokens, max-json-bytes" in said, said)
    expect("a token is asked for", running.status()[0] == 401)
    status, body = running.status(token=reader)
    expect("and lets in", status == 200, status, body)
    expect("the new limit holds", json.loads(body)["limits"]["max_json_bytes"] == 1234, body)
    data = mesh(10, 1)
    expect("reading is not uploading",
           running.status("POST", "/v1/meshes", reader, data)[0] == 403)
    expect("probes need no token", running.status(path="/readyz")[0] == 200)

    running.tokens(reader_line, uploader_line, "mallory admin " + "0" * 63)
    said = running.hang_up()
    expect("a broken file is refused with its line",
           "nothing was changed" in said and "tokens:4: the third field" in said, said)
    expect("and all stays as it was",
           running.status(token=reader)[0] == 200 and running.status(token=uploader)[0] == 401)
    running.tokens(uploader_line)
    running.config({**options, "io-threads": 7, "queue": 0})
    said = running.hang_up()
    expect("what needs a restart is named", "waiting for a restart: io-threads" in said, said)
    expect("a token that is gone is refused", running.status(token=reader)[0] == 401)
    expect("a new one uploads",
           running.status("POST", "/v1/meshes", uploader, data)[0] == 201)
    expect("but does not read", running.status(token=uploader)[0] == 403)
    (folder / "config.json").write_text("{")
    expect("a broken configuration is refused", "nothing was changed" in running.hang_up())
    expect("and all stays as it was",
           running.status("POST", "/v1/meshes", uploader, data)[0] == 200)
    expect("it ends well", running.stop() == 0)
    log = "".join(running.lines)
    expect("the log has lines of requests", "/v1/meshes" in log, log)
    expect("the log holds no token and no hash",
           not any(secret in log for secret in
                   (reader, uploader, reader_line.split()[2], uploader_line.split()[2], "0" * 63)))


def checks(program, folder):
    """--check-config, good and bad."""
    store = folder / "unmade"
    status, out, errors = run(program, "--check-config", "--store", str(store))
    expect("a good configuration is valid",
           (status, out, errors) == (0, "configuration is valid\n", ""), status, out, errors)
    expect("no store was made", not store.exists())
    bad = folder / "bad.json"
    bad.write_text('{"queue": "many", "tokens": "%s"}' % (folder / "none"))
    status, out, errors = run(program, "--check-config", "--config", str(bad), "--store", "s3://",
                              "--max-faces", "0", "--colour")
    expect("a bad one exits with 2 and lists all that is wrong",
           status == 2 and out == "" and len(errors.splitlines()) == 5, status, out, errors)
    status, out, errors = run(program, "--tokens", str(folder / "none"), "--store", str(store))
    expect("the process does not start without the tokens it is told of",
           status != 0 and "none: cannot be read" in out + errors, status, out, errors)


def main():
    """Runs both; exits with 1 if something was not as it must be."""
    program = os.path.abspath(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        reloads(program, pathlib.Path(folder))
        checks(program, pathlib.Path(folder))
    sys.exit(failures != 0)


if __name__ == "__main__":
    main()
