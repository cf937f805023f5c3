#!/usr/bin/env bash
# Prepare this checkout: the packages that building and testing need, and .venv with the command `evenspin`.
#
#   [PYTHON=<command>] tools/setup/setup.sh
#
# What is already there is left alone. As root on Debian 12 or 13 missing packages are installed; otherwise the command
# that installs them is printed, and setup goes on if it can.
# Exit status: 0 ready, 1 a step failed (its log is build/setup.log), 3 something that setup cannot do without is missing.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/../.."
readonly ROOT=$PWD
readonly LOG=$ROOT/build/setup.log
readonly VENV=$ROOT/.venv
readonly CMOCK_TREE=/usr/share/cmock

say() { printf '[setup] %s\n' "$*"; }

# run WHAT COMMAND...: do it quietly; say what is being done, and show the end of the log if it fails.
run() {
    local what=$1
    shift
    say "$what"
    if ! log "$@"; then
        say "failed: $what; the end of build/setup.log:"
        tail -n 30 "$LOG"
        exit 1
    fi
}

log() {
    mkdir -p "$(dirname "$LOG")"
    { printf '\n$ %s\n' "$*" && "$@"; } >>"$LOG" 2>&1
}

# ---- packages ------------------------------------------------------------------------------------------------------

has() { command -v "$1" >/dev/null 2>&1; }
has_c_library() { printf '#include <math.h>\n' | "$1" -E -x c - >/dev/null 2>&1; }
has_cmock() { [ -f "$CMOCK_TREE/lib/cmock.rb" ]; }

# The Python for .venv: recent enough, and able to make a virtual environment.
find_python() {
    local candidate
    for candidate in ${PYTHON:-} python3 python3.13 python3.12 python3.11 python3.14; do
        if has "$candidate" && "$candidate" -c '
import sys, venv, ensurepip
sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1; then
            printf '%s\n' "$candidate"
            return 0
        fi
    done
    return 1
}

essential=() # without these there is no `evenspin`
testing=()   # only `make test` needs these

# The one list of packages: what shows that it is there, and who needs it.
list_missing() {
    essential=() testing=()
    has gcc || essential+=(gcc)
    { has gcc && has_c_library gcc; } || essential+=(libc6-dev)
    has cmake || essential+=(cmake)
    has ninja || essential+=(ninja-build)
    [ -x "$VENV/bin/python" ] || find_python >/dev/null || essential+=(python3 python3-venv)
    has make || testing+=(make)
    has ruby || testing+=(ruby)
    has_cmock || testing+=(cmock)
    has arm-none-eabi-gcc || testing+=(gcc-arm-none-eabi)
    { has arm-none-eabi-gcc && has_c_library arm-none-eabi-gcc; } || testing+=(libnewlib-arm-none-eabi)
    has avr-gcc || testing+=(gcc-avr avr-libc)
    { has simavr && [ -f /usr/include/simavr/sim_avr.h ] && [ -f /usr/include/libelf.h ]; } ||
        testing+=(simavr libsimavr-dev libelf-dev)
    has qemu-system-arm || testing+=(qemu-system-arm)
    has cppcheck || testing+=(cppcheck)
    has chromium || testing+=(chromium)
    has chromedriver || testing+=(chromium-driver)
    local clang
    clang=$([ "$(codename)" = bookworm ] && echo 16 || echo 19)
    has clang-16 || has clang-19 || testing+=("clang-$clang")
    compgen -G '/usr/lib/llvm-*/lib/clang/*/lib/linux/libclang_rt.fuzzer-*.a' >/dev/null || testing+=("libclang-rt-$clang-dev")
}

apt_install() {
    DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=300 install -y --no-install-recommends "$@"
}

codename() { (. /etc/os-release && printf '%s\n' "${VERSION_CODENAME:-}"); }

# CMock is in Debian from trixie on and is independent of the machine. On bookworm this takes that one package from
# the mirror that the system uses already, with apt's own checks of the signature, and leaves the system's sources
# as they are.
install_cmock_from_trixie() (
    set -e
    dir=$(mktemp -d)
    trap 'rm -rf "$dir"' EXIT
    chmod 755 "$dir"
    mkdir -p "$dir/lists/partial" "$dir/cache/archives/partial"
    mirror=$(apt-get indextargets --format '$(RELEASE) $(COMPONENT) $(REPO_URI)' 'Created-By: Packages' |
        awk '$1 == "bookworm" && $2 == "main" { print $3; exit }')
    [ -n "$mirror" ] || { echo "apt has no source for bookworm/main"; exit 1; }
    printf 'deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] %s trixie main\n' "${mirror%/}" >"$dir/list"
    apart=(-o "Dir::Etc::sourcelist=$dir/list" -o Dir::Etc::sourceparts=/nonexistent
        -o Dir::Etc::preferencesparts=/nonexistent -o "Dir::State::lists=$dir/lists" -o "Dir::Cache=$dir/cache")
    apt-get "${apart[@]}" -q update
    cd "$dir"
    apt-get "${apart[@]}" -q download cmock
    dpkg -i cmock_*_all.deb
)

install_missing() {
    local package wanted=() cmock=no
    for package in "${essential[@]}" "${testing[@]}"; do
        if [ "$package" = cmock ]; then cmock=yes; else wanted+=("$package"); fi
    done
    run "reading the package lists" apt-get -q -o DPkg::Lock::Timeout=300 update
    if [ ${#wanted[@]} -gt 0 ]; then
        run "installing ${wanted[*]}" apt_install "${wanted[@]}"
    fi
    if [ $cmock = yes ]; then
        say "installing cmock"
        if [ "$(codename)" = bookworm ]; then
            log install_cmock_from_trixie || true
        else
            log apt_install cmock || true
        fi
    fi
    list_missing
}

report_missing() {
    local package wanted=()
    for package in "${essential[@]}" "${testing[@]}"; do
        if [ "$package" != cmock ] || [ "$(codename)" != bookworm ]; then
            wanted+=("$package")
        fi
    done
    if [ ${#wanted[@]} -gt 0 ]; then
        say "missing, please install: sudo apt-get install -y --no-install-recommends ${wanted[*]}"
    fi
    if ! has_cmock; then
        has git || say "git is missing, too; CMake needs it for the next point"
        say "without cmock CMake fetches its pinned upstream release, for the tests"
    fi
    if [ ${#essential[@]} -gt 0 ]; then
        say "stopping here: without ${essential[*]} there is no evenspin"
        exit 3
    fi
    if [ ${#wanted[@]} -gt 0 ]; then
        say "going on: only make test needs these"
    fi
}

# ---- Python --------------------------------------------------------------------------------------------------------

# True if anything that the compiled part of the package is made of is newer than the last installation. Directories
# count, so that a removed file is noticed; Python files do not, they are used where they are.
sources_changed() {
    [ ! -e "$1" ] || [ -n "$(find control hal firmware sim_host cmake CMakeLists.txt pyproject.toml -newer "$1" -print -quit)" ]
}

# uv takes a quarter of pip's processor time, and reads nothing of pip's configuration: where that says more about sources
# than uv is given here, or uv fails, pip installs.
install_with_uv() {
    local python=$VENV/bin/python
    if "$python" -m pip config list | grep -vqE '\.(cert|find-links|default-timeout|timeout|disable-pip-version-check|cache-dir)='; then
        return 1
    fi
    log "$python" -m pip --disable-pip-version-check --no-input install uv &&
        log env ${PIP_CERT:+"SSL_CERT_FILE=$PIP_CERT"} ${PIP_FIND_LINKS:+"UV_FIND_LINKS=${PIP_FIND_LINKS// /,}"} \
            "$VENV/bin/uv" pip install --quiet --python "$python" "$@"
}

install_package() {
    local python requirements=$VENV/.requirements installed=$VENV/.installed

    # A moved or half-made environment is made again: its scripts hold the path of the checkout.
    if ! [ -e "$requirements" ] || [ "$(<"$requirements")" != "$ROOT" ] || ! "$VENV/bin/python" -c '' 2>/dev/null; then
        python=$(find_python) || { say "no Python >= 3.11 with venv and ensurepip was found"; exit 3; }
        rm -rf "$VENV"
        run "making .venv with $("$python" --version)" "$python" -m venv "$VENV"
    fi
    local pip=("$VENV/bin/python" -m pip --disable-pip-version-check --no-input install)

    if [ ! -e "$requirements" ] || [ pyproject.toml -nt "$requirements" ]; then
        local wanted
        mapfile -t wanted < <("$VENV/bin/python" -c '
import tomllib
with open("pyproject.toml", "rb") as file:
    config = tomllib.load(file)
project = config["project"]
print(*config["build-system"]["requires"], *project["dependencies"], *project["optional-dependencies"]["test"], sep="\n")')
        rm -f "$installed"
        say "installing the Python packages that evenspin needs"
        if ! install_with_uv "${wanted[@]}"; then
            run "installing them with pip" "${pip[@]}" --no-compile "${wanted[@]}"
        fi
        # byte code on all cores, without the packages' own tests; some have files that are not Python
        log "$VENV/bin/python" -m compileall -q -j 0 -x '/tests?/' "$VENV/lib" || true
        printf '%s\n' "$ROOT" >"$requirements"
    fi
    if sources_changed "$installed" || [ ! -x "$VENV/bin/evenspin" ]; then
        mkdir -p build
        touch build/setup.started # what changes during the build is built next time
        run "building evenspin" "${pip[@]}" --no-deps --no-build-isolation \
            --config-settings=build-dir=build/py --editable .
        mv build/setup.started "$installed"
    fi
}

# ---- all of it -----------------------------------------------------------------------------------------------------

list_missing
if [ $((${#essential[@]} + ${#testing[@]})) -gt 0 ]; then
    if [ "$(id -u)" -eq 0 ] && has apt-get; then
        install_missing
    fi
    if [ $((${#essential[@]} + ${#testing[@]})) -gt 0 ]; then
        report_missing
    fi
fi
install_package
say "ready: .venv/bin/evenspin"
