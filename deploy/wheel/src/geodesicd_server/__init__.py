"""The program of geodesicd; ``geodesic serve``, of the package ``geodesicd``, starts it."""

from pathlib import Path

PROGRAM = Path(__file__).parent / "bin" / "geodesicd"
