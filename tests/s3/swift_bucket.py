"""A real S3 server with an empty bucket for as long as a test lasts: OpenStack Swift.

    with bucket() as there:
        if there is None: ...  # there is no Swift here, which was said
        f"s3://{BUCKET}/prefix?endpoint={there.endpoint}"  # with KEYS in the environment
"""

import contextlib
import dataclasses
import hashlib
import os
import pathlib
import subprocess
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
# Debian's own: python3-swift is installed for no other.
PYTHON = "/usr/bin/python3"
BUCKET = "meshes"
KEYS = {"AWS_ACCESS_KEY_ID": "test:tester", "AWS_SECRET_ACCESS_KEY": "testing", "NO_PROXY": "*"}


@dataclasses.dataclass
class Bucket:
    """Where it is, and a folder for the test's own files."""

    endpoint: str
    folder: pathlib.Path
    proxy: int  # the process that answers, to be stopped for a while
    server: subprocess.Popen

    def stop(self):
        """Nobody answers any more."""
        self.server.terminate()
        self.server.wait()


def _has_attributes(place):
    """Whether files below a folder can have user attributes, which Swift needs."""
    with tempfile.TemporaryDirectory(prefix="s3_test_", dir=place) as name:
        try:
            os.setxattr(name, "user.test", b"1")
        except OSError:
            return False
        return True


def _make(endpoint, folder):
    """An empty bucket."""
    # On a command line, curl would end the user's name at its colon.
    netrc = folder / "netrc"
    netrc.write_text(f"default login {KEYS['AWS_ACCESS_KEY_ID']}"
                     f" password {KEYS['AWS_SECRET_ACCESS_KEY']}\n")
    empty = hashlib.sha256(b"").hexdigest()
    subprocess.run(
        # Swift says 503 until all of its parts are up.
        ["curl", "--silent", "--show-error", "--fail", "--retry", "8", "--request", "PUT",
         "--netrc-file", netrc, "--aws-sigv4", "aws:amz:us-east-1:s3", "--header", f"x-amz-content-sha256: {empty}",
         "--noproxy", "*", f"{endpoint}/{BUCKET}"], check=True)


@contextlib.contextmanager
def bucket():
    """The bucket; None where there can be none here."""
    found = subprocess.run([PYTHON, "-c", "import swift"], capture_output=True, check=False)
    if found.returncode != 0:
        print("skipped: no S3 server: scripts/setup s3 installs python3-swift")
        yield None
        return
    places = [place for place in (tempfile.gettempdir(), os.getcwd()) if _has_attributes(place)]
    if not places:
        print("skipped: no file system with user attributes for Swift here")
        yield None
        return
    with tempfile.TemporaryDirectory(prefix="s3_test_", dir=places[0]) as name:
        folder = pathlib.Path(name)
        server = subprocess.Popen([PYTHON, str(HERE / "swift_server.py"), str(folder / "swift")],
                                  stdout=subprocess.PIPE, text=True)
        try:
            said = server.stdout.readline()
            if not said.startswith("listening on "):
                for log in sorted((folder / "swift").glob("*.log")):
                    print(f"-- {log.name}\n{log.read_text(errors='replace')[-2000:]}")
                raise RuntimeError("the S3 server did not start")
            there = Bucket(said.split()[-1], folder, int((folder / "swift" / "proxy.pid").read_text()), server)
            _make(there.endpoint, folder)
            yield there
        finally:
            server.terminate()
            server.wait()
