"""The clients of torture.py: what each does, and what it takes for a fault."""

import collections
import contextlib
import hashlib
import http.client
import json
import random
import socket
import threading
import time

from torture_meshes import MUDDY, glb, obj
from torture_questions import OF_THE_MOMENT, batch_of, is_same

# What an error may say, by status. All else is a fault.
CODES = {
    400: {"bad_syntax", "unknown_parameter"},
    404: {"mesh_unknown", "job_unknown"},
    406: {"not_acceptable"},
    408: {"request_timeout"},
    409: {"job_unfinished", "job_cancelled"},
    413: {"too_large"},
    422: {"index_out_of_range", "value_out_of_range", "snap_too_far", "outside_region", "no_hit", "no_loop", "unsupported",
          "mesh_invalid", "no_triangles", "too_much_memory"},
    429: {"too_many_requests"},
    499: {"cancelled"},
    503: {"overloaded", "store_unavailable"},
    504: {"deadline"},
}
PATIENCE = 60  # seconds in which any answer must come
LATE = 10      # seconds by which an answer may pass its own deadline
RECEIVE_GRACE = 5  # seconds that a body may take: longer only where the whole machine stood still

MOST_KEPT = 100_000  # bytes of an answer that is kept to compare with again

Reply = collections.namedtuple("Reply", "status headers body")


class Connection:
    """A client's connection, opened again whenever it has ended."""

    def __init__(self, port):
        self._port = port
        self._http = None

    def send(self, method, target, body=None, headers=None):
        """Begins a request."""
        if self._http is None:
            self._http = http.client.HTTPConnection("127.0.0.1", self._port, timeout=PATIENCE)
            self._http.connect()
            self._http.sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._http.request(method, target, body=body, headers=headers or {})

    def ask(self, method, target, body=None, headers=None):
        """The reply. A connection that ended while nobody used it is opened anew."""
        for last in (False, True):
            try:
                self.send(method, target, body, headers)
                reply = self._http.getresponse()
                content = reply.read()
                return Reply(reply.status, {k.lower(): v for k, v in reply.getheaders()}, content)
            except (http.client.RemoteDisconnected, ConnectionResetError, BrokenPipeError,
                    http.client.CannotSendRequest):
                self.hang_up()
                if last:
                    raise
            except BaseException:
                self.hang_up()
                raise
        return None

    def hang_up(self):
        """Leaves, whatever is under way."""
        if self._http is not None:
            with contextlib.suppress(OSError):
                self._http.close()
        self._http = None


class Quiet:
    """The server that is asked one question at a time, and what it has answered."""

    def __init__(self, service):
        self._connection = Connection(service.port)
        self._lock = threading.Lock()
        self._known = set()
        self._answers = collections.OrderedDict()

    def answer(self, mesh, question):
        """What the question is answered with where nothing else goes on."""
        with self._lock:
            key = (mesh.id, *question)
            if key not in self._answers:
                if mesh.id not in self._known:
                    self._connection.ask("POST", "/v1/meshes" + mesh.options, mesh.data)
                    self._known.add(mesh.id)
                answer = self._connection.ask(question.method, mesh.base + question.target, question.body)
                if len(answer.body) > MOST_KEPT:
                    return answer
                self._answers[key] = answer
                if len(self._answers) > 2000:
                    self._answers.popitem(last=False)
            return self._answers[key]


class Mesh:
    """One to ask about."""

    def __init__(self, kind, shape, name, options=""):
        self.kind = kind
        self.shape = shape
        self.options = options
        self.data = (glb if kind in MUDDY else obj)(shape, name)
        self.vertices, self.faces = len(shape[0]), len(shape[1])
        self.id = hashlib.sha256(self.data).hexdigest()  # until an upload has told, where there are options
        self.questions = collections.deque(maxlen=12)  # asked lately, to be asked again
        self.may_be_gone = False

    @property
    def base(self):
        """Where it is."""
        return f"/v1/meshes/{self.id}"


class Client(threading.Thread):
    """Does one thing after the other until it is told to stop."""

    def __init__(self, torture, number):
        super().__init__(daemon=True)
        self._torture = torture
        self._chance = random.Random(f"{torture.seed}/{number}")
        self._connection = Connection(torture.port)
        self.own = torture.own_meshes(number)  # nobody else deletes these
        self.now = None  # (since when, what)
        self.done = collections.Counter()

    def fault(self, what, *details):
        """Something was not as it must be."""
        self._torture.fault(" ".join(str(part)[:400] for part in (what, *details)))

    def run(self):
        deeds = [(60, self._query), (8, self._batch), (8, self._job), (6, self._own_mesh),
                 (5, self._shared_mesh), (8, self._hang_up), (2, self._look_round)]
        weights, acts = zip(*deeds)
        while not self._torture.over.is_set():
            act = self._chance.choices(acts, weights)[0]
            try:
                act()
                self.done[act.__name__.strip("_")] += 1
            except (OSError, http.client.HTTPException) as error:
                # A stream of rows that meets a limit is broken off.
                is_cut = isinstance(error, http.client.IncompleteRead) and "stream" in str(self.now)
                if not self._torture.over.is_set() and not is_cut:
                    self.fault("no answer:", self.now, type(error).__name__, error)
                self._connection.hang_up()
            except (ValueError, KeyError, TypeError) as error:
                self.fault("answer cannot be read:", self.now, type(error).__name__, error)
            self.now = None
        self._connection.hang_up()

    def _ask(self, method, target, body=None, headers=None):
        self.now = (time.monotonic(), f"{method} {target} {body if body and len(body) < 2000 else ''}")
        reply = self._connection.ask(method, target, body, headers)
        self.done[reply.status] += 1
        if reply.status >= 300:
            self._judge_error(reply)
        return reply

    def _judge_error(self, reply):
        problem = json.loads(reply.body)
        code = problem.get("code")
        if "problem+json" not in reply.headers.get("content-type", ""):
            self.fault("an error is no problem:", self.now, reply)
        if problem.get("status") != reply.status or code not in CODES.get(reply.status, ()):
            self.fault("an error does not fit:", self.now, reply.status, reply.body)
        if reply.status == 408 and time.monotonic() - self.now[0] < RECEIVE_GRACE:
            self.fault("the body was there in time:", self.now, reply)
        if reply.status in (429, 503) and "retry-after" not in reply.headers:
            self.fault("no Retry-After:", self.now, reply)

    def _compare(self, mesh, question, reply):
        """One reply with what the quiet server says."""
        error = json.loads(reply.body)["code"] if reply.status >= 300 else None
        if error == "mesh_unknown" and not mesh.may_be_gone:
            self.fault("lost:", mesh.kind, self.now)
        if error in OF_THE_MOMENT:
            return
        expected = self._torture.quiet.answer(mesh, question)
        if expected.status == 504:
            return  # it was a deadline that the quiet server did not keep
        if expected.status != reply.status:
            self.fault("another status:", mesh.kind, self.now, reply.status, reply.body,
                       "quiet:", expected.status, expected.body)
        elif error is not None:
            theirs = json.loads(expected.body)["code"]
            if theirs != error:
                self.fault("another error:", mesh.kind, self.now, error, "quiet:", theirs)
        elif not is_same(question, reply, expected):
            self._torture.differs(mesh, question, reply, expected)

    def _query(self):
        mesh = self._chance.choice(self._torture.meshes + self.own)
        question = self._torture.next_question(mesh, self._chance)
        self._compare_timed(mesh, question, lambda: self._ask(
            question.method, mesh.base + question.target, question.body))

    def _compare_timed(self, mesh, question, ask):
        began = time.monotonic()
        reply = ask()
        took = time.monotonic() - began
        if took > question.deadline + LATE:
            self.fault(f"past its deadline, {took:.1f} s:", mesh.kind, self.now)
        self._compare(mesh, question, reply)

    def _batch(self):
        mesh = self._chance.choice(self._torture.meshes)
        question = batch_of(self._chance, mesh)
        self._compare(mesh, question, self._ask("POST", mesh.base + question.target, question.body))

    def _job(self):
        mesh = self._chance.choice(self._torture.meshes)
        question = self._torture.next_question(mesh, self._chance)
        reply = self._ask(question.method, mesh.base + question.target, question.body,
                          {"Prefer": "respond-async"})
        if reply.status != 202:
            return self._compare(mesh, question, reply)
        job = "/v1/jobs/" + json.loads(reply.body)["id"]
        fate = self._chance.random()
        if fate < 0.4:  # cancelled, at once or a little later
            time.sleep(self._chance.choice([0, 0, 0.001, 0.01, 0.1]))
            if self._ask("DELETE", job).status != 204:
                self.fault("not cancelled:", self.now)
            return None
        if fate < 0.5:  # left alone
            return None
        if fate < 0.6:  # watched for a moment
            self._connection.send("GET", job + "/events")
            time.sleep(self._chance.random() / 20)
            return self._connection.hang_up()
        until = time.monotonic() + PATIENCE
        while time.monotonic() < until and not self._torture.over.is_set():
            state = self._ask("GET", job)
            if state.status == 404:
                return None  # it has ended, and was forgotten
            if json.loads(state.body)["state"] in ("done", "failed", "cancelled"):
                result = self._ask("GET", job + "/result")
                self.now = (time.monotonic(), f"job {question.method} {mesh.base}{question.target}")
                return self._compare(mesh, question, result)
            time.sleep(0.01)
        if not self._torture.over.is_set():
            self.fault("a job that does not end:", question, state.body)
        return None

    def _upload(self, mesh):
        """Whether it was acknowledged."""
        as_job = self._chance.random() < 0.1
        reply = self._ask("POST", "/v1/meshes" + mesh.options, mesh.data,
                          {"Prefer": "respond-async"} if as_job else {})
        if reply.status == 202:
            job = "/v1/jobs/" + json.loads(reply.body)["id"]
            until = time.monotonic() + PATIENCE
            while time.monotonic() < until:
                reply = self._ask("GET", job + "/result")
                if reply.status != 409:
                    break
                time.sleep(0.02)
        if reply.status in (200, 201):
            mesh.id = json.loads(reply.body)["id"]
            return True
        return False

    def _own_mesh(self):
        """Deletes one of its own, and uploads it again."""
        if not self.own:
            return
        mesh = self._chance.choice(self.own)
        if mesh.may_be_gone:
            if self._upload(mesh):
                mesh.may_be_gone = False
            return
        if self._chance.random() < 0.5:
            if self._ask("GET", mesh.base).status == 404:
                self.fault("lost:", mesh.kind, self.now)
            return
        mesh.may_be_gone = True
        reply = self._ask("DELETE", mesh.base)
        if reply.status == 204 and self._ask("GET", mesh.base + "/source").status != 404:
            self.fault("deleted and there:", mesh.kind, self.now)
        if self._chance.random() < 0.8 and self._upload(mesh):
            mesh.may_be_gone = False
            reply = self._ask("GET", mesh.base + "/source")
            if reply.status not in (429, 503) and (reply.status, reply.body) != (200, mesh.data):
                self.fault("uploaded and not there:", mesh.kind, self.now, reply.status)

    def _shared_mesh(self):
        """One that all upload and delete."""
        mesh = self._chance.choice(self._torture.coming_and_going)
        kind = self._chance.random()
        if kind < 0.4:
            self._upload(mesh)
        elif kind < 0.6:
            self._ask("DELETE", mesh.base)
        else:
            question = self._torture.next_question(mesh, self._chance)
            self._compare_timed(mesh, question, lambda: self._ask(
                question.method, mesh.base + question.target, question.body))

    def _hang_up(self):
        """Asks, and leaves before the answer, or in the middle of the question."""
        mesh = self._chance.choice(self._torture.meshes + self._torture.coming_and_going)
        question = self._torture.next_question(mesh, self._chance)
        if self._chance.random() < 0.3:
            data = self._chance.choice([mesh.data, b"GET /v1/status HTTP/1.1\r\nHost: x\r\n\r\n"])
            with socket.create_connection(("127.0.0.1", self._torture.port), PATIENCE) as raw:
                raw.sendall(b"POST /v1/meshes HTTP/1.1\r\nHost: x\r\nContent-Length: %d\r\n\r\n"
                            % len(data) + data[:self._chance.randrange(len(data))])
            return
        self._connection.send(question.method, mesh.base + question.target, question.body)
        time.sleep(self._chance.choice([0, 0, 0.001, 0.01]))
        self._connection.hang_up()

    def _look_round(self):
        target = self._chance.choice(["/v1/status", "/v1/methods", "/metrics", "/v1/meshes?limit=7",
                                      "/debug/cache", "/readyz"])
        if self._ask("GET", target).status != 200:
            self.fault("not 200:", self.now)
