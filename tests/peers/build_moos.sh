#!/bin/sh
# MOOSDB, pShare, pObstacleMgr and uFldCollObDetect from source, as peers of bridge and missions: build_moos.sh SOURCE OUT
# SOURCE: a clone of moos-ivp/moos-ivp at a2a9b716c; OUT: the programs come to OUT/bin. Then, in the project:
#     ODS_MOOS=OUT/bin pytest -m slow tests/bridge/test_moos_peer.py tests/peers/test_other_referee.py
# GPL and LGPL: they run beside ODS in tests and are no part of it. Debian: git cmake g++ make.
set -eu

[ $# = 2 ] || { echo "usage: build_moos.sh SOURCE OUT" >&2 && exit 2; }
source=$(cd "$1" && pwd)
mkdir -p "$2/bin"
out=$(cd "$2" && pwd)
jobs=$(getconf _NPROCESSORS_ONLN)

configure() { # FROM TO OPTION...
    from=$1 to=$2
    shift 2
    cmake -S "$from" -B "$to" -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_FLAGS="-w -O1 -fPIC" \
        -DCMAKE_RUNTIME_OUTPUT_DIRECTORY="$out/bin" "$@" >"$to.log" 2>&1 || { tail -20 "$to.log" >&2 && exit 1; }
}

configure "$source/MOOS_Jul2724/MOOSCore" "$out/core" -DENABLE_EXPORT=ON -DUSE_ASYNC_COMMS=ON
make -C "$out/core" -j "$jobs" MOOS MOOSDB >"$out/core.log" 2>&1
configure "$source/MOOS_Jul2724/MOOSEssentials" "$out/essentials" -DMOOS_DIR="$out/core"
make -C "$out/essentials" -j "$jobs" pShare >"$out/essentials.log" 2>&1
configure "$source/MOOS_Jul2724/MOOSGeodesy" "$out/geodesy" -DMOOS_DIR="$out/core" -DMOOSGEODESY_USE_PROJ=OFF \
    -DMOOSGEODESY_FETCH_PROJ=OFF
make -C "$out/geodesy" -j "$jobs" >"$out/geodesy.log" 2>&1
configure "$source/ivp/src" "$out/ivp" -DMOOS_DIR="$out/core" -DMOOSGeodesy_DIR="$out/geodesy" -DIVP_BUILD_GUI_CODE=OFF \
    -DIVP_BIN_DIRECTORY="$out/bin" -DIVP_LIB_DIRECTORY="$out/lib"
make -C "$out/ivp" -j "$jobs" pObstacleMgr uFldCollObDetect >"$out/ivp.log" 2>&1
ls "$out/bin"
