#!/usr/bin/env python3
"""Runs a program with the system calls that a container or a service of systemd would have.

    seccomp_filter.py profile FILE -- PROGRAM ARGUMENTS...
    seccomp_filter.py unit FILE -- PROGRAM ARGUMENTS...

FILE is a profile as container engines read them, for a container without capabilities, or a unit, of
which this knows SystemCallFilter, SystemCallErrorNumber, RestrictAddressFamilies, RestrictNamespaces,
RestrictRealtime, LockPersonality and MemoryDenyWriteExecute. libseccomp makes the filters, as it does
for systemd and for engines.
"""

import ctypes
import errno
import json
import os
import platform
import socket
import subprocess
import sys

ALLOW, ERRNO = 0x7FFF0000, 0x00050000
EQUAL, MASKED = 4, 7
OPERATORS = {"SCMP_CMP_NE": 1, "SCMP_CMP_LT": 2, "SCMP_CMP_LE": 3, "SCMP_CMP_EQ": EQUAL, "SCMP_CMP_GE": 5,
             "SCMP_CMP_GT": 6, "SCMP_CMP_MASKED_EQ": MASKED}
ARCHES = {"x86_64": "amd64", "aarch64": "arm64"}
NAMESPACES = (0x80, 0x20000, 0x2000000, 0x4000000, 0x8000000, 0x10000000, 0x20000000, 0x40000000)
REALTIME = (1, 2, 6)  # the policies FIFO, RR and DEADLINE
WRITE, EXECUTE = 2, 4


class Comparison(ctypes.Structure):
    """libseccomp's scmp_arg_cmp."""

    _fields_ = [("argument", ctypes.c_uint), ("operator", ctypes.c_int), ("a", ctypes.c_uint64),
                ("b", ctypes.c_uint64)]


LIBRARY = ctypes.CDLL("libseccomp.so.2", use_errno=True)
LIBRARY.seccomp_init.restype = ctypes.c_void_p
LIBRARY.seccomp_init.argtypes = [ctypes.c_uint32]
LIBRARY.seccomp_load.argtypes = [ctypes.c_void_p]
LIBRARY.seccomp_rule_add_array.argtypes = [ctypes.c_void_p, ctypes.c_uint32, ctypes.c_int, ctypes.c_uint,
                                           ctypes.POINTER(Comparison)]


class Filter:
    """One filter: what it says of calls that no rule names, and its rules."""

    def __init__(self, action):
        self._default, self._filter = action, LIBRARY.seccomp_init(action)

    def add(self, action, name, *comparisons):
        """A rule for a call, if this machine has that; a comparison is (argument, operator, a, b)."""
        number = LIBRARY.seccomp_syscall_resolve_name(name.encode())
        if number < 0 or action == self._default:
            return
        rules = (Comparison * len(comparisons))(*comparisons)
        failed = LIBRARY.seccomp_rule_add_array(self._filter, action, number, len(comparisons), rules)
        if failed:
            raise OSError(-failed, f"no rule for {name}: {os.strerror(-failed)}")

    def load(self):
        """From here on it holds, and no program that is started gets more rights by it."""
        failed = LIBRARY.seccomp_load(self._filter)
        if failed:
            raise OSError(-failed, f"the filter cannot be loaded: {os.strerror(-failed)}")


def load_profile(file):
    """A container engine's profile, as it is for a container without capabilities."""
    with open(file, encoding="utf-8") as text:
        profile = json.load(text)
    default = profile["defaultAction"]
    assert default == "SCMP_ACT_ERRNO", default
    actions = {"SCMP_ACT_ALLOW": lambda rule: ALLOW,
               "SCMP_ACT_ERRNO": lambda rule: ERRNO | rule.get("errnoRet", errno.EPERM)}
    made = Filter(ERRNO | profile.get("defaultErrnoRet", errno.EPERM))
    for rule in profile["syscalls"]:
        includes = rule.get("includes") or {}
        if includes.get("caps") or ARCHES.get(platform.machine()) not in includes.get(
                "arches", ARCHES.values()):
            continue
        comparisons = [(its["index"], OPERATORS[its["op"]], its["value"], its.get("valueTwo", 0))
                       for its in rule.get("args") or []]
        for name in rule["names"]:
            made.add(actions[rule["action"]](rule), name, *comparisons)
    made.load()


def settings_of(file):
    """A unit's settings: all values of each, in their order."""
    found = {}
    with open(file, encoding="utf-8") as text:
        for line in text:
            name, is_setting, value = line.strip().partition("=")
            if is_setting and not line.startswith("#"):
                found.setdefault(name, []).append(value)
    return found


def groups_of_calls():
    """systemd's groups of system calls, such as @system-service, each with its calls and groups."""
    said = subprocess.run(["systemd-analyze", "syscall-filter", "--no-pager"], capture_output=True, text=True,
                          check=True)
    groups, group = {}, None
    for line in said.stdout.splitlines():
        if line.startswith("@"):
            group = groups.setdefault(line.strip(), [])
        elif line.startswith(" ") and group is not None and not line.strip().startswith("#"):
            group.append(line.strip())
    return groups


def calls_of(words, groups):
    """The names of calls behind names of calls and groups."""
    return {call for word in words
            for call in (calls_of(groups[word], groups) if word.startswith("@") else [word])}


def allowed_calls(values):
    """What several SystemCallFilter leave, of which the first is a list of what is allowed."""
    groups = groups_of_calls()
    allowed = calls_of(["@default"], groups)
    for value in values:
        listed = calls_of(value.removeprefix("~").split(), groups)
        allowed = allowed - listed if value.startswith("~") else allowed | listed
    return allowed


def load_unit(file):
    """The filters that systemd would give to a unit."""
    unit = settings_of(file)
    refusal = ERRNO | errno.EPERM
    rest = Filter(ALLOW)
    if unit.get("RestrictAddressFamilies"):
        mine = {int(getattr(socket, name)) for name in unit["RestrictAddressFamilies"][0].split()}
        for family in set(range(64)) - mine:
            rest.add(ERRNO | errno.EAFNOSUPPORT, "socket", (0, EQUAL, family, 0))
    if unit.get("RestrictNamespaces") == ["yes"]:
        for kind in NAMESPACES:
            for call in ("clone", "unshare"):
                rest.add(refusal, call, (0, MASKED, kind, kind))
        rest.add(refusal, "setns")
        rest.add(ERRNO | errno.ENOSYS, "clone3")
    if unit.get("RestrictRealtime") == ["yes"]:
        for policy in REALTIME:
            rest.add(refusal, "sched_setscheduler", (1, EQUAL, policy, 0))
    if unit.get("LockPersonality") == ["yes"]:
        for bits in range(32):
            rest.add(refusal, "personality", (0, MASKED, 1 << bits, 1 << bits))
    if unit.get("MemoryDenyWriteExecute") == ["yes"]:
        rest.add(refusal, "mmap", (2, MASKED, WRITE | EXECUTE, WRITE | EXECUTE))
        for call in ("mprotect", "pkey_mprotect"):
            rest.add(refusal, call, (2, MASKED, EXECUTE, EXECUTE))
    rest.load()
    assert unit["SystemCallErrorNumber"] == ["EPERM"]
    calls = Filter(refusal)
    # systemd leaves the way to the program open, too.
    for call in allowed_calls(unit["SystemCallFilter"]) | {"execve"}:
        calls.add(ALLOW, call)
    calls.load()


if __name__ == "__main__":
    {"profile": load_profile, "unit": load_unit}[sys.argv[1]](sys.argv[2])
    assert sys.argv[3] == "--"
    os.execv(sys.argv[4], sys.argv[4:])
