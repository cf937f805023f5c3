"""The command `evenspin`: parses and prints; no physics."""

from evenspin.cli.main import main

__all__ = ["main"]
