"""What schemathesis does not know: which ids and numbers are of the mesh that is there.
An id of the right form becomes that mesh's, vertices and faces are taken round, and a
deadline is no less than a minute, so that most requests are answered; what is of another
form stays as it is."""

import os
import re

import schemathesis

MESH = os.environ["CONTRACT_MESH"]
VERTICES, FACES = 10000, 19602  # of plane.glb


def _fitting(value):
    if isinstance(value, list):
        return [_fitting(item) for item in value]
    if isinstance(value, dict):
        fitted = {key: _fitting(item) for key, item in value.items()}
        for key, count in (("vertex", VERTICES), ("face", FACES)):
            if isinstance(fitted.get(key), int) and fitted[key] > 0:
                fitted[key] %= count
        if re.fullmatch("[1-9][0-9]{0,4}", str(fitted.get("deadline_ms", ""))):
            fitted["deadline_ms"] = 60000
        return fitted
    if isinstance(value, str):
        value = re.sub(r"^v:([0-9]+)$", lambda m: f"v:{int(m[1]) % VERTICES}", value)
        return re.sub(r"^f:([0-9]+),.*$", lambda m: f"f:{int(m[1]) % FACES},0.25,0.5", value)
    return value


@schemathesis.serializer("application/x-ndjson")
def lines(context, value):
    """A text is sent as it is."""
    del context
    return value if isinstance(value, bytes) else str(value).encode("utf-8", "replace")


@schemathesis.hook
def before_call(context, case, kwargs):
    """Fits every request, whichever phase made it."""
    del context, kwargs
    if re.fullmatch("[0-9a-f]{64}", str((case.path_parameters or {}).get("id", ""))):
        case.path_parameters["id"] = MESH
    for part in ("query", "body"):
        value = getattr(case, part)
        if isinstance(value, (dict, list)):
            setattr(case, part, _fitting(value))
