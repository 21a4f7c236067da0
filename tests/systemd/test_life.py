"""The life of an installation, in this order: installed, switched on, faults, upgrade, reboot, removal."""

from collections.abc import Callable

import pytest

from tests.systemd.life import UNITS, Life

pytestmark = pytest.mark.timeout(1800)

CONFIG = "/etc/ods/onboard.toml"


def test_the_containerfiles_line_installs_without_systemd(containers_lines: str) -> None:
    assert "installing ODS" in containers_lines


def test_install_makes_everything_and_says_what_is_next(installed: str) -> None:
    assert "starts with the computer" in installed


def test_all_units_are_active(life: Life, figure: Callable[[str], None]) -> None:
    life.wait_for_all_active()
    figure(f"all units active at {life.guest.run('cat', '/proc/uptime').split()[0]} s")


def test_starting_does_not_wait_for_a_sonar_that_is_off(life: Life) -> None:
    life.guest.run("systemctl", "stop", "test-far-end")
    try:
        life.guest.run("systemctl", "restart", "ods.target", timeout_s=200.0)
        life.wait_for(lambda: life.states()["ods@sonar.service"] == "activating")  # it may still be stopping
    finally:  # the tests after this one need it
        life.guest.run("systemctl", "start", "test-far-end")
    life.wait_for_all_active()


def test_poses_by_can_and_pings_by_serial_line_become_obstacles_for_a_planner_of_group_ods(life: Life) -> None:
    picture = life.planner()
    assert (picture.valid, picture.reasons) == (True, [])
    assert any(abs(north - 40.0) < 3.0 and abs(east - 5.0) < 3.0 for north, east, _ in picture.positions)


def test_a_user_outside_the_group_is_refused_and_reported_so(life: Life) -> None:
    picture = life.planner("stranger", patience_s=3.0)
    assert not picture.valid
    assert "no permission to open" in picture.reasons[0]


def test_the_processes_run_as_ods(life: Life) -> None:
    for unit in UNITS:
        assert life.guest.run("stat", "-c", "%U", f"/proc/{life.pid_of(unit)}") == "ods"


@pytest.mark.parametrize("process", ["pipeline", "tracker"])
def test_a_user_without_a_home_can_start_a_process_by_hand(life: Life, process: str) -> None:
    other = "/tmp/nobody/onboard.toml"
    bus = r's|^\[bus\]|[bus]\nrun_dir = "/tmp/nobody/run"|; s|/var/lib/ods|/tmp/nobody|'
    life.guest.run("sh", "-c", f"install -d -o nobody /tmp/nobody; cp /etc/ods/* /tmp/nobody; sed -i '{bus}' {other}")
    nobody = "setpriv --reuid=65534 --regid=65534 --clear-groups env -i HOME=/nonexistent PATH=/usr/bin:/bin"
    ods = f"{nobody} /opt/ods/bin/ods {process} --config {other}"
    pid = life.guest.run("sh", "-c", f"{ods} >/tmp/nobody/said 2>&1 & echo $!")
    life.wait_for(lambda: f"{process}: ready" in life.guest.run("cat", "/tmp/nobody/said"))
    said = life.guest.run("sh", "-c", f"kill {pid}; cat /tmp/nobody/said; rm -rf /tmp/nobody; true")
    assert "Traceback" not in said


def test_only_root_can_change_the_program(life: Life) -> None:
    assert (
        life.guest.run("find", "/opt/ods", "!", "-type", "l", "(", "!", "-user", "root", "-o", "-perm", "/022", ")")
        == ""
    )


def test_the_journal_is_for_its_group(life: Life) -> None:
    assert "ready" in life.journal("planner")
    assert "ready" not in life.journal("stranger")


def test_doctor_finds_all_processes_well(life: Life) -> None:
    text = life.guest.ask("/opt/ods/bin/ods", "doctor", "--config", CONFIG, user="ods")[1]
    for name in ("nav", "sonar", "pipeline", "tracker"):
        assert f"{name}: runs without problems" in text


@pytest.mark.parametrize(("signal", "said"), [("STOP", "Watchdog timeout"), ("KILL", "status=9/KILL")])
def test_processes_that_hang_or_die_are_replaced(
    life: Life, signal: str, said: str, figure: Callable[[str], None]
) -> None:
    pids = {unit: life.pid_of(unit) for unit in UNITS}
    life.guest.run("kill", f"-{signal}", *map(str, pids.values()))
    took_s = life.seconds_until_replaced(pids)
    figure(f"all four back {took_s:.1f} s after SIG{signal}")
    assert said in life.journal()
    assert life.planner().valid


def test_a_process_that_fails_on_a_broken_configuration_is_back_when_it_is_mended(life: Life) -> None:
    unit = "ods@tracker.service"
    life.guest.run("cp", CONFIG, "/root/good.toml")
    life.guest.run("sh", "-c", f"echo '[no_such_table]' >>{CONFIG}")
    pid = life.pid_of(unit)
    life.guest.run("kill", "-KILL", str(pid))
    life.wait_for(lambda: int(life.property_of(unit, "NRestarts")) >= 8)  # systemd's own limit is five in ten seconds
    assert "no_such_table" in life.journal()
    life.guest.run("cp", "/root/good.toml", CONFIG)
    life.seconds_until_replaced({unit: pid})
    assert life.planner().valid


def test_a_map_made_by_root_is_reported_with_what_mends_it_and_is_then_used(life: Life) -> None:
    unit, path = "ods@tracker.service", "/var/lib/ods/map.sqlite"
    life.guest.run("systemctl", "stop", unit)
    life.guest.run("sh", "-c", f"chown root:root {path}*")
    life.guest.run("systemctl", "start", unit)
    life.wait_for(lambda: "belongs to root" in life.property_of(unit, "StatusText"))
    reported = life.property_of(unit, "StatusText").partition("; not read for ")[0]
    assert f"{path} may not be written by user ods, as it belongs to root: as root, `chown ods {path}*`" in reported
    assert reported in life.journal()
    life.guest.run("sh", "-c", reported.split("`")[1])
    life.wait_for(lambda: life.property_of(unit, "StatusText") == "all is well")


def test_an_upgrade_keeps_the_configuration_and_restarts_what_runs(life: Life) -> None:
    life.guest.run("sh", "-c", f"echo '# of the user' >>{CONFIG}")
    newer = life.guest.run("sh", "-c", "echo /newer/ods-*.whl")
    life.guest.run("systemctl", "stop", "ods@pipeline")
    pids = {unit: life.pid_of(unit) for unit in UNITS}
    install = ("env", "PIP_NO_INDEX=1", "PIP_FIND_LINKS=/wheels", "make", "-C", "/src", "install", f"WHEEL={newer}")
    said = life.guest.run(*install, timeout_s=800.0)
    assert f"kept as it is: {CONFIG}" in said
    assert "ods 99.0" in said
    assert life.states()["ods@pipeline.service"] == "inactive"  # somebody wanted that
    life.guest.run("systemctl", "start", "ods.target", timeout_s=200.0)
    life.seconds_until_replaced(pids)
    assert life.planner().valid


def test_after_a_reboot_it_comes_up_by_itself(life: Life, figure: Callable[[str], None]) -> None:
    life.guest.shut_down()
    life.guest.switch_on()
    picture = life.planner()
    assert (picture.valid, picture.reasons) == (True, [])
    figure(f"first valid list {picture.up_s:.1f} s after power-on")


def test_uninstall_leaves_what_it_says_and_nothing_else(life: Life) -> None:
    said = life.guest.run("make", "-C", "/src", "uninstall")
    assert "left are /etc/ods, /var/lib/ods and the user and group ods" in said
    assert life.guest.ask("systemctl", "is-active", *UNITS)[1].split() == ["inactive"] * 4
    assert _traces(life) == {"/etc/ods", "/var/lib/ods"}
    assert "nothing of ODS is left" in life.guest.run("make", "-C", "/src", "uninstall", "PURGE=1")
    assert _traces(life) == set()
    assert life.guest.ask("getent", "passwd", "ods")[0] != 0
    assert life.guest.ask("getent", "group", "ods")[0] != 0


def _traces(life: Life) -> set[str]:
    """Return all files and folders by whose name ODS can be known, but not what is in them."""
    named = ["-name", "ods", "-o", "-name", "ods[.@-]*", "-o", "-name", "*-ods*"]
    return set(
        life.guest.run("find", "/etc", "/opt", "/run", "/usr", "/var", "(", *named, ")", "-prune", "-print").split()
    )
