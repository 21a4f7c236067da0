#!/bin/sh
# `make uninstall`: stops ODS and takes the program away; with PURGE=1 also configuration, state and user.
set -eu

UNITS=/etc/systemd/system

[ "$(id -u)" = 0 ] || { echo "make uninstall: only root can: sudo make uninstall" >&2 && exit 2; }
[ -e $UNITS/ods@.service ] || [ "${PURGE:-}" = 1 ] || { echo "make uninstall: ODS is not installed here" >&2 && exit 2; }

if [ -e $UNITS/ods@.service ]; then
    prefix=$(sed -n 's|^ExecStart=\(.*\)/bin/ods .*|\1|p' $UNITS/ods@.service)
    systemctl --quiet disable ods.target
    [ ! -d /run/systemd/system ] || systemctl stop ods.target 'ods@*.service'
    rm -rf $UNITS/ods@record.service.d $UNITS/ods@listen.service.d $UNITS/ods@bridge_*.service.d
    rm -f $UNITS/ods@.service $UNITS/ods.target /etc/udev/rules.d/90-ods-serial.rules /etc/sysctl.d/90-ods.conf
    [ ! -d /run/systemd/system ] || systemctl daemon-reload
    [ ! -e "$prefix/pyvenv.cfg" ] || rm -rf "$prefix"
fi
rm -rf /run/ods /var/cache/ods
if [ "${PURGE:-}" = 1 ]; then
    rm -rf /etc/ods /var/lib/ods
    ! getent passwd ods >/dev/null || userdel ods 2>/dev/null # it says that the group has other members
    ! getent group ods >/dev/null || groupdel ods
    echo "make uninstall: nothing of ODS is left"
else
    echo "make uninstall: left are /etc/ods, /var/lib/ods and the user and group ods; without them: make uninstall PURGE=1"
fi
