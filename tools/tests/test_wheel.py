"""The wheel, installed where there is no checkout: it has everything that it needs, and its commands do their work."""

import fcntl
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import urllib.request
import venv
import zipfile
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import urlsplit

import pytest

ROOT = Path(__file__).parents[2]
SCENARIO = 'name = "s"\nmodel = "guo2024"\nduration_s = 2.0\n[[event]]\nat_s = 0.0\nspeed_rpm = 200.0\n'
ALONE = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
PIP = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]


@pytest.fixture(scope="session")
def wheel(tmp_path_factory):
    """Built once for all processes, in the folder in which `make setup` builds: only what has changed is compiled."""
    own = tmp_path_factory.getbasetemp()  # of this process; that of the session is above it where there are several
    shared = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "wheel"
    with _alone(ROOT / "build" / ".wheel-lock"):
        if not shared.exists():
            shared.mkdir()
            where = ["--config-settings=build-dir=build/py", "--wheel-dir", shared]
            _run([*PIP, "wheel", ROOT, "--no-deps", "--no-build-isolation", *where], cwd=ROOT)
        return next(shared.glob("*.whl"))


@pytest.fixture(scope="session")
def installed(wheel, tmp_path_factory):
    """An environment with the wheel; its dependencies are those of this environment, which takes no time."""
    place = tmp_path_factory.mktemp("environment")
    venv.create(place, symlinks=True)
    _run([*PIP, "--python", place / "bin" / "python", "install", "--no-deps", "--no-index", wheel])
    packages = next(place.glob("lib/python*/site-packages"))
    (packages / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return place / "bin"


@contextmanager
def _alone(path):
    path.parent.mkdir(exist_ok=True)
    with path.open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def _run(words, **options):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, timeout=300, **options)
    assert done.returncode == 0, done.stderr
    return done.stdout


@contextmanager
def _started(words, cwd):
    """A command that goes on; its first line."""
    process = subprocess.Popen(
        [str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, cwd=cwd, env=ALONE
    )
    try:
        assert process.stdout is not None
        yield process.stdout.readline()
    finally:
        process.terminate()
        process.wait(20.0)


def test_every_file_of_the_package_is_in_the_wheel(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    source = ROOT / "tools" / "src"
    git = shutil.which("git") if (ROOT / ".git").exists() else None
    if git is None:
        pytest.skip("not a checkout")
    tracked = _run([git, "ls-files", "evenspin"], cwd=source).split()

    assert {name for name in tracked if (source / name).is_file()} - names == set()
    assert {f"evenspin/_lib/libevenspin_{numeric}.so" for numeric in ("float", "fixed")} <= names


def test_the_command_is_that_of_the_wheel(installed, tmp_path):
    where = _run([installed / "python", "-c", "import evenspin; print(evenspin.__file__)"], cwd=tmp_path, env=ALONE)

    assert where.startswith(str(installed.parent))
    assert re.match(r"evenspin \d", _run([installed / "evenspin", "--version"], cwd=tmp_path, env=ALONE))


def test_a_scenario_runs_and_its_log_is_explained(installed, tmp_path):
    (tmp_path / "s.toml").write_text(SCENARIO)

    _run([installed / "evenspin", "run", "s.toml", "--out", "run"], cwd=tmp_path, env=ALONE)
    said = _run(
        [installed / "evenspin", "gap", "run/s.csv", "--model", "guo2024", "--out", "gap"], cwd=tmp_path, env=ALONE
    )

    assert "var uPlot" in (tmp_path / "run" / "report.html").read_text()
    assert "Verdict" in said and (tmp_path / "gap" / "verdict.json").is_file()


def test_a_virtual_drive_answers_and_the_scope_has_its_page(installed, tmp_path):
    evenspin = installed / "evenspin"
    with _started([evenspin, "drive", "--tcp", "127.0.0.1:0"], tmp_path) as line:
        port = re.search(r"socket:\S+", line)[0]
        assert "simulator" in _run([evenspin, "bench", "info", "--port", port], cwd=tmp_path, env=ALONE)
        with _started([evenspin, "scope", "--port", port, "--http-port", "0"], tmp_path) as page:
            address = urlsplit(re.search(r"http://\S+", page)[0])
            text = urllib.request.urlopen(address.geturl(), timeout=10.0).read().decode()
            vendor = address._replace(path="/static/vendor/uPlot.iife.min.js")  # with the token of the page
            script = urllib.request.urlopen(vendor.geturl(), timeout=10.0)

    assert "<title>" in text and script.status == 200
