"""The built-in model with sensor noise and nothing hidden, as text to change."""

from importlib.resources import files

MODEL = files("evenspin").joinpath("data", "models", "servo.toml").read_text(encoding="utf-8")
