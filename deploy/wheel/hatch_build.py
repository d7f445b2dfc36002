"""A wheel with a program in it is for machines of one kind."""

from __future__ import annotations

import sysconfig
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class MachinesTag(BuildHookInterface[Any]):
    """Names the machine in the wheel's tag."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Called by hatchling before it builds."""
        program = Path(self.root) / "src" / "geodesicd_server" / "bin" / "geodesicd"
        if not program.is_file():
            raise FileNotFoundError(f"no program at {program}: scripts/build_wheels puts it there")
        platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{platform}"
