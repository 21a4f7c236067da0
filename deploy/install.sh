#!/bin/sh
# `make install`: the program, its user, configuration and units. Again with a newer version: an upgrade.
# WHEEL=FILE installs a wheel that `make wheel` made elsewhere, where this computer has no C compiler.
# `install.sh program` leaves out what needs systemd: for a container.
set -eu
umask 022
cd "$(dirname "$0")/.."

PREFIX=${PREFIX:-/opt/ods}
PYTHON=${PYTHON:-python3}
CONFIG=${CONFIG:-config/onboard.toml}
ETC=/etc/ods
UNITS=/etc/systemd/system

main() {
    check
    [ "${1:-}" = program ] || check_systemd
    scratch=$(mktemp -d)
    trap 'rm -rf "$scratch"' EXIT
    install_program
    make_user
    install_configuration
    [ "${1:-}" = program ] || install_units
}

say() {
    echo "make install: $*"
}

fail() {
    say "$*" >&2
    exit 2
}

check() {
    [ "$(id -u)" = 0 ] || fail "only root can: sudo make install"
    case $PREFIX in
        /*[!A-Za-z0-9/._-]* | [!/]* | /) fail "PREFIX=$PREFIX: give an absolute path of letters, digits and ._-" ;;
    esac
    "$PYTHON" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null ||
        fail "no Python 3.11 or newer as $PYTHON: apt-get install python3, or name one with PYTHON="
    "$PYTHON" -c 'import ensurepip, venv' 2>/dev/null || fail "$PYTHON makes no virtual environments: apt-get install python3-venv"
    as 65534 "$("$PYTHON" -c 'import os, sys; print(os.path.realpath(sys.executable))')" -c '' 2>/dev/null ||
        fail "other users cannot run $PYTHON, as it lies in a folder of root's: PYTHON=/usr/bin/python3"
    if [ -n "${WHEEL:-}" ]; then
        [ -f "$WHEEL" ] || fail "WHEEL=$WHEEL: there is no such file"
    elif ! include=$("$PYTHON" -c 'import sysconfig; print(sysconfig.get_path("include"))') || [ ! -e "$include/Python.h" ] ||
        ! command -v cc >/dev/null; then
        fail "no C compiler for the kernels: apt-get install gcc libc6-dev python3-dev, or give WHEEL=FILE (make wheel elsewhere)"
    fi
    if [ -d "$PREFIX" ] && [ -n "$(ls -A "$PREFIX")" ] && [ ! -e "$PREFIX/pyvenv.cfg" ]; then
        fail "PREFIX=$PREFIX holds something else: name a folder of its own"
    fi
}

check_systemd() {
    command -v systemctl >/dev/null || fail "no systemd here: see docs/installation.md for other ways"
    there=$(sed -n 's|^ExecStart=\(.*\)/bin/ods .*|\1|p' $UNITS/ods@.service 2>/dev/null) || true
    [ -z "$there" ] || [ "$there" = "$PREFIX" ] || fail "ODS is installed in $there: PREFIX=$there, or make uninstall first"
}

as() { # USER COMMAND...: as a user with nothing of root's environment
    user=$1
    shift
    setpriv --reuid="$user" --regid="$user" --clear-groups env -i PATH="$PATH" "$@"
}

install_program() { # the wheel is built of a copy, so that nothing of root's is left in the source tree
    version='import sys; print(sys.version)'
    if [ "$("$PREFIX/bin/python" -c "$version" 2>/dev/null)" != "$("$PYTHON" -c "$version")" ]; then
        say "virtual environment in $PREFIX"
        "$PYTHON" -m venv "$PREFIX"
    fi
    say "installing ODS and what it needs"
    pip="$PREFIX/bin/python -m pip --quiet --disable-pip-version-check"
    wheel=${WHEEL:-}
    if [ -z "$wheel" ]; then
        cp -r pyproject.toml setup.py README.md LICENSE config ods "$scratch"
        $pip wheel --no-deps --wheel-dir "$scratch/wheel" "$scratch"
        wheel=$(ls "$scratch"/wheel/*.whl)
    fi
    $pip install -c constraints.txt "$wheel"
    $pip install --no-deps --force-reinstall "$wheel" # also when the version is the same
    "$PREFIX/bin/python" -P -c 'from ods.compiled import native' || fail "the kernels cannot be loaded: see above"
}

make_user() {
    getent passwd ods >/dev/null ||
        useradd --system --user-group --groups dialout --no-create-home --home-dir /var/lib/ods --shell /usr/sbin/nologin ods
}

install_configuration() {
    install -d $ETC
    sed 's@^\(path\|folder\) = "~/.local/state/ods/@\1 = "/var/lib/ods/@' "$CONFIG" >"$scratch/onboard.toml"
    for file in "$scratch/onboard.toml" config/*.eds config/*.dbc; do
        target=$ETC/$(basename "$file")
        if [ ! -e "$target" ]; then
            install -m 644 "$file" "$target"
            say "new: $target"
        elif ! cmp -s "$file" "$target"; then
            say "kept as it is: $target (this version brings another; to compare: $PREFIX/lib/python*/site-packages/ods/config_files)"
        fi
    done
}

install_units() {
    sed "s|/opt/ods/|$PREFIX/|" deploy/ods@.service >"$scratch/ods@.service"
    install -m 644 "$scratch/ods@.service" deploy/ods.target $UNITS
    sed "s|/opt/ods/|$PREFIX/|" deploy/record.conf >"$scratch/record.conf"
    install -D -m 644 "$scratch/record.conf" $UNITS/ods@record.service.d/record.conf
    sed "s|/opt/ods/|$PREFIX/|" deploy/listen.conf >"$scratch/listen.conf"
    install -D -m 644 "$scratch/listen.conf" $UNITS/ods@listen.service.d/listen.conf
    for bridge in $(grep -o 'bridge_[a-z0-9]*' deploy/ods.target | cut -d _ -f 2); do
        sed "s|/opt/ods/|$PREFIX/|; s|NAME|$bridge|" deploy/bridge.conf >"$scratch/bridge.conf"
        install -D -m 644 "$scratch/bridge.conf" "$UNITS/ods@bridge_$bridge.service.d/bridge.conf"
    done
    install -D -m 644 deploy/90-ods-serial.rules /etc/udev/rules.d/90-ods-serial.rules
    install -D -m 644 deploy/90-ods.conf /etc/sysctl.d/90-ods.conf
    [ -n "$there" ] || systemctl --quiet enable ods.target # whoever disabled it since, meant it
    version=$("$PREFIX/bin/ods" --version)
    if [ ! -d /run/systemd/system ]; then
        say "$version in $PREFIX starts with the computer"
        return
    fi
    systemctl daemon-reload
    udevadm control --reload
    sysctl --quiet --load=/etc/sysctl.d/90-ods.conf || true # a container may not
    if [ -n "$there" ]; then
        systemctl --no-block try-restart 'ods@*.service' # not to wait for a sonar that is off
        say "$version in $PREFIX: what ran is restarted"
        return
    fi
    say "$version in $PREFIX starts with the computer, or now: systemctl start ods.target"
    say "first edit $ETC/onboard.toml, and try it: sudo -u ods $PREFIX/bin/ods doctor --config $ETC/onboard.toml --listen 3"
}

main "$@"
