"""The one counter table: what each counter of a health report, a recorder or a read file means, and who reports it.

Whoever counts uses a plain `collections.Counter`; a name without a row here is refused by the tests. The pages
of docs/counters/, the doctor's advice, and what is worth a line in the log come from this table.
"""

import os
from collections.abc import Iterable
from typing import NamedTuple

from ods.runtime import bus
from ods.runtime.processes import PROCESSES


class CounterRow(NamedTuple):
    """One row of the counter table."""

    name: str
    meaning: str
    trouble: bool = True
    """False: the doctor says nothing of it, because nothing is wrong, or because a problem line reports it."""
    logged: bool = False
    """The first one is worth a line in the log."""
    advice: str = ""
    """What the doctor says of it."""


REFUSE = "ODS_REFUSE_UNKNOWN_COUNTERS"
RECORDER, RECORDINGS, SIM_DEVICES = "s7k recorder", "recordings", "simulated devices"
OWN_RECORDINGS, REPLAY = "recordings of ods", "ods replay"
"""Those that count besides the processes of the process table: recorders, readers of files, the bench's devices."""

_POSE_BUFFER = (
    CounterRow("pose_bad", "poses dropped: not finite, attitude not a unit quaternion, negative sigma"),
    CounterRow("pose_duplicate", "poses dropped: the same time as another"),
    CounterRow("pose_too_old", "poses dropped: older than all in a full buffer"),
    CounterRow("pose_thinned", "poses not used: more than `pose.max_rate_hz`", trouble=False),
)

_LISTS = (
    CounterRow("withheld_lists", "lists not sent: not valid, too old, or without the vehicle's pose", trouble=False),
    CounterRow("paced_lists", "lists not sent: replaced by newer ones before they were due", trouble=False),
    CounterRow("left_out_obstacles", "obstacles not sent because others are nearer", trouble=False),
)
_BRIDGE = (
    *_LISTS,
    CounterRow("sent_lists", "lists sent in full", trouble=False),
    CounterRow("sent_datagrams", "datagrams sent", trouble=False),
    CounterRow("refused_datagrams", "datagrams refused: no program listens on the receiver's port"),
    CounterRow("unsent_datagrams", "datagrams not sent: no route, or a full socket buffer"),
)
_BRIDGE_ROS2 = (
    *_LISTS,
    CounterRow("sent_lists", "lists sent in full", trouble=False),
    CounterRow("sent_messages", "messages sent, of all topics", trouble=False),
    CounterRow("unheard_lists", "lists not sent because no node has subscribed", trouble=False),
    CounterRow("unsent_messages", "messages not sent: no interface, or DDS refused"),
    CounterRow("interface_losses", "times the interface was missing or changed its address, or DDS failed to start"),
    CounterRow("unfit_images", "images whose samples do not fit their shape"),
)

_OWN: dict[str, tuple[CounterRow, ...]] = {
    "listen": (
        CounterRow("passed_messages", "messages passed on, per address", trouble=False),
        CounterRow("admitted_clients", "clients let in by their key", trouble=False),
        CounterRow("refused_clients", "clients refused: their key is not, or no longer, in the list"),
        CounterRow("hang_ups", "times an address's clients were disconnected: a key was revoked", trouble=False),
        CounterRow("listen_errors", "failed attempts to listen: the port is in use, or the interface is missing"),
    ),
    **{name: _BRIDGE for name in PROCESSES if name.startswith("bridge_")},
    "bridge_ros2": _BRIDGE_ROS2,
    "sonar": (
        CounterRow("pings", "pings published", trouble=False),
        CounterRow("beams", "beams of a mechanically scanned sonar", trouble=False),
        CounterRow("lost_pings", "ping numbers without a complete ping", logged=True,
                   advice="ping numbers without a complete ping: noise, an overloaded line, or a busy processor"),
        CounterRow("duplicate_pings", "samples of a ping already published"),
        CounterRow("ping_number_restarts", "gaps of more than 1000 ping numbers: the sonar restarted",
                   logged=True),
        CounterRow("records", "complete records", trouble=False),
        CounterRow("other_records", "other records, not used", trouble=False),
        CounterRow("unchecked_records", "records without a checksum, by their flags", trouble=False),
        CounterRow("network_frames", "network frames (s7k over TCP)", trouble=False),
        CounterRow("unframed_bytes", "bytes outside network frames", logged=True,
                   advice="bytes outside network frames: is this the port of a 7k center?"),
        CounterRow("lying_frames", "network frames of a wrong length: another one begins inside", logged=True),
        CounterRow("garbage_bytes", "bytes outside records",
                   advice="bytes outside records: noise, or records truncated by a baud rate that is too low"),
        CounterRow("bad_version", "false starts of a record"),
        CounterRow("bad_offset", "false starts of a record"),
        CounterRow("unknown_message", "Oculus, Norbit: false starts of a message; Sonar 3D-15: other datagrams"),
        CounterRow("stranger_datagrams", "Sonar 3D-15: datagrams from another sender than sonar.sonar3d15.sender",
                   trouble=False, logged=True),
        CounterRow("short_record", "false starts of a record"),
        CounterRow("overlong_record", "records longer than `sonar.max_record_bytes`", logged=True),
        CounterRow("bad_checksum", "records with a wrong checksum", logged=True,
                   advice="the line damages bytes: check termination, ground, cable"),
        CounterRow("nested_record", "false starts of a record"),
        CounterRow("truncated_record", "records not complete within `sonar.record_timeout_s`"),
        CounterRow("bad_settings", "unusable records 7000", logged=True),
        CounterRow("bad_beam_table", "unusable records 7004", logged=True),
        CounterRow("bad_water_column", "unusable records 7018 and 7042", logged=True),
        CounterRow("bad_remote_control", "unusable answers to remote control", logged=True),
        CounterRow("unsupported_layout", "samples in an unknown layout", logged=True),
        CounterRow("data_without_settings", "samples without record 7000", logged=True,
                   advice="samples without record 7000: switch it on at the sonar, for every ping"),
        CounterRow("data_without_geometry", "samples without record 7004", logged=True,
                   advice="samples without record 7004: switch it on at the sonar, for every ping"),
        CounterRow("bad_ping", "samples that do not fit settings and beam table", logged=True),
        CounterRow("no_device_time", "pings stamped by arrival: the sonar reports no time", trouble=False,
                   logged=True),
        CounterRow("device_clock_jumps", "jumps of the sonar's clock"),
        CounterRow("wild_device_times", "time stamps off the sonar's clock by more than 0.5 s"),
        CounterRow("pings_held_back", "pings more than 0.5 s late by the sonar's clock", logged=True,
                   advice="pings more than 0.5 s late by the sonar's clock: delayed on the line; if that clock had "
                   "stopped, as in a paused player, restart sonar"),
        CounterRow("port_opens", "times the port was opened", trouble=False),
        CounterRow("port_losses", "times the port was lost", logged=True),
        CounterRow("port_open_errors", "failed attempts to open the port"),
        CounterRow("statuses", "Oculus: statuses", trouble=False),
        CounterRow("other_statuses", "Oculus: statuses of other sonars", trouble=False),
        CounterRow("bad_status", "Oculus: malformed statuses"),
        CounterRow("control_requests", "requests sent, repetitions too", trouble=False),
        CounterRow("control_acknowledged", "requests acknowledged", trouble=False),
        CounterRow("control_refused", "requests refused", logged=True),
        CounterRow("control_lost", "requests without effect after `sonar.control_attempts`", logged=True),
        CounterRow("control_unsent", "requests that the line did not accept", logged=True),
    ),
    "pipeline": (
        CounterRow("detections", "detections published", trouble=False),
        CounterRow("bad_ping", "pings dropped: their content contradicts itself", logged=True),
        CounterRow("beams_without_pose", "beams without a pose, for which that of other beams is used", trouble=False),
        CounterRow("failed_stage", "pings dropped: a stage failed, or gave values that are not finite", logged=True),
        CounterRow("skipped_pings", "pings skipped because the chain is too slow", logged=True,
                   advice="pings skipped because the chain is too slow: remove stages, set pipeline.attention, or set "
                   "a lower ping rate"),
        CounterRow("geometry_changes", "changes of beams or ranges: stages are prepared again", trouble=False),
        CounterRow("drop_out_image", "images without usable data (drop-out)"),
        CounterRow("unseen_images", "images with blind parts",
                   advice="images with unobserved parts: `ods watch` says which, and why"),
        CounterRow("pings_without_pose", "pings without a pose for the stages that compare pings"),
        CounterRow("process_mean_us", "running mean of the time per ping, us", trouble=False),
        CounterRow("process_max_us", "longest time per ping, us", trouble=False),
        *_POSE_BUFFER,
    ),
    "tracker": (
        CounterRow("echoes_bad", "detections ignored: not finite or out of range"),
        CounterRow("skipped_pings", "pings skipped: too many objects or echoes for this computer", logged=True,
                   advice="pings skipped: too many objects or echoes for this computer: raise the detector's "
                   "threshold"),
        CounterRow("detections_late", "pings not later than the previous one, ignored", logged=True),
        CounterRow("detections_from_future", "pings stamped more than 1 s ahead, ignored", logged=True),
        CounterRow("pings_without_pose", "pings without a pose at transmission: objects are only predicted"),
        CounterRow("poses_from_future", "poses stamped more than 1 s ahead, ignored", logged=True),
        CounterRow("pose_jumps", "jumps of the INS's position or heading", logged=True,
                   advice="jumps of the INS's position or heading: earlier objects are dropped, and the list is not "
                   "valid for 1 s"),
        CounterRow("pings_without_reception_pose",
                   "pings without a pose at reception, or without a sound speed: the pose at transmission is used"),
        CounterRow("utc_steps", "steps of UTC by more than 1 s: stamps since the start are corrected", trouble=False),
        CounterRow("obstacle_not_finite", "obstacles omitted from a list: not finite"),
        CounterRow("checkpoint_unusable", "unusable checkpoints of an earlier tracker", logged=True),
        CounterRow("checkpoint_failed", "checkpoints not written to the run folder", logged=True),
        CounterRow("map_not_finite", "objects omitted from the map: not finite", logged=True),
        CounterRow("map_unusable", "failed attempts to read the map", logged=True),
        CounterRow("map_write_failed", "failed attempts to write the map", logged=True),
        CounterRow("map_stalled", "times the disk delayed the map by more than 3 s", logged=True),
        CounterRow("map_process_lost", "times the map's process ended and was restarted", logged=True),
        CounterRow("veto_orders", "requests to ignore, forget or restore, refused ones too", trouble=False),
        CounterRow("vetoes_refused", "requests refused"),
        CounterRow("vetoes_over", "vetoes that expired or whose obstacle left their area", trouble=False),
        CounterRow("refused_operators", "attempts to veto without an operator's key"),
        CounterRow("bad_veto-requests", "operators' requests that are malformed or too long"),
        *_POSE_BUFFER,
    ),
    "nav": (
        CounterRow("poses", "poses published", trouble=False),
        CounterRow("frame_short", "DBC: frames too short"),
        CounterRow("frame_not_finite", "DBC: frames with a float that is not a number"),
        CounterRow("frame_other_sender", "DBC: frames of a second sender of one parameter group", logged=True,
                   advice="choose one with nav.dbc.source_address"),
        CounterRow("frame_twin", "DBC: frames with a mapped number, but the other identifier length"),
        CounterRow("nmea_sentences", "NMEA: sentences used", trouble=False),
        CounterRow("nmea_other", "NMEA: sentences of other kinds or talkers", trouble=False),
        CounterRow("nmea_damaged", "NMEA: damaged lines", logged=True,
                   advice="check baud, ground, cable, and whether two devices send on one line"),
        CounterRow("nmea_talkers", "NMEA: sentences used from two talkers", logged=True,
                   advice="name one in nav.nmea"),
        CounterRow("nmea_no_checksum", "NMEA: sentences without a checksum", logged=True,
                   advice="let the sender append it (*hh)"),
        CounterRow("nmea_no_fix", "NMEA: sentences used by nav.nmea.accept: estimated, manual, simulated or unsafe"),
        CounterRow("nmea_not_valid", "NMEA: sentences flagged as not valid"),
        CounterRow("line_overlong", "NMEA: lines longer than 255 bytes", logged=True,
                   advice="is this a line with NMEA, and nav.nmea.baud right?"),
        CounterRow("stranger_datagrams", "NMEA: datagrams from another sender than nav.nmea.sender", logged=True),
        CounterRow("port_opens", "NMEA: times the port was opened", trouble=False),
        CounterRow("port_losses", "NMEA: times the port was lost", logged=True),
        CounterRow("port_open_errors", "NMEA: failed attempts to open the port"),
        CounterRow("frame_unplaced", "DBC: frames before the order of an instant's messages is known", trouble=False),
        CounterRow("epoch_parted", "DBC: epochs with the longest silence inside, not before"),
        CounterRow("epoch_aged", "poses dropped: a held value is too old"),
        CounterRow("frame_stray", "DBC: frames out of order, repeated, or without the first of their epoch"),
        CounterRow("epoch_unproven", "DBC: epochs after an incomplete one"),
        CounterRow("pdo_short", "PDOs shorter than their mapping"),
        CounterRow("pdo_duplicate", "PDOs received twice in an epoch"),
        CounterRow("pdo_stray", "PDOs out of order, without a sequence number"),
        CounterRow("epoch_torn", "incomplete epochs dropped"),
        CounterRow("epoch_missing", "CANopen: sequence numbers never seen"),
        CounterRow("sequence_reset", "times the sequence number went back: the INS restarted"),
        CounterRow("epoch_invalid", "poses dropped: a required status is not set"),
        CounterRow("epoch_absurd", "poses dropped: a field out of range"),
        CounterRow("altitude_absurd", "altitudes omitted: not above 0, not a number, or (or their sigma) above "
                   "`nav.limits.altitude_m`", logged=True),
        CounterRow("altitude_still", "altitudes omitted: constant while the vehicle rises or sinks", logged=True,
                   advice="the altimeter hangs, or detects no bottom and reports its longest range"),
        CounterRow("epoch_late", "poses dropped: too old"),
        CounterRow("epoch_contested", "poses dropped: two nodes send as the INS"),
        CounterRow("epoch_untimed", "poses without a valid time of day"),
        CounterRow("ins_twice", "frames of a second node with the INS's id"),
        CounterRow("own_id_taken", "frames of a second node with the id of ODS"),
        CounterRow("ins_clock_jumps", "jumps of the INS's clock"),
        CounterRow("ins_clock_wild", "time stamps that do not fit the INS's clock"),
        CounterRow("wall_clock_steps", "steps of this computer's clock by more than 0.1 s"),
        CounterRow("heartbeat_bad", "malformed heartbeats"),
        CounterRow("emcy", "emergency messages", trouble=False),
        CounterRow("emcy_bad", "malformed emergency messages"),
        CounterRow("ins_boot_up", "boot-ups of the INS", trouble=False),
        CounterRow("sync", "SYNC messages", trouble=False),
        CounterRow("time", "TIME messages", trouble=False),
        CounterRow("time_bad", "malformed TIME messages; TIME and ZDA not of 2020 to 2099"),
        CounterRow("time_wild", "TIME messages off by more than 0.5 s"),
        CounterRow("time_jumps", "jumps of TIME: four messages in a row agree"),
        CounterRow("node_frame_bad", "malformed NMT commands and SDO requests"),
        CounterRow("can_opened", "times the CAN interface was opened", trouble=False),
        CounterRow("can_lost", "times the CAN interface failed"),
        CounterRow("can_silent", "times the CAN interface was closed because no frame came"),
        CounterRow("can_extended", "CANopen: frames with 29-bit identifiers"),
        CounterRow("can_ignored", "remote and FD frames", trouble=False),
        CounterRow("can_overflow", "frames dropped by the kernel: its receive buffer was full"),
        CounterRow("can_error_frames", "error frames of the CAN controller"),
        CounterRow("can_bus_off", "times the controller went bus-off"),
        CounterRow("can_recovered", "ends of bus-off"),
        CounterRow("can_garbage", "slcan: lines that are neither frame nor answer"),
        CounterRow("can_unsent", "frames that the bus did not accept"),
    ),
    "planner": (
        CounterRow("set_points", "set points published", trouble=False),
        CounterRow("not_valid", "set points from a list that is not valid or too old", trouble=False),
        CounterRow("can_opened", "times the CAN interface was opened", trouble=False),
        CounterRow("can_unsent", "set points that the bus did not accept"),
    ),
    "sim": (
        CounterRow("pings_late", "pings sent late"),
        CounterRow("sonar_bytes_lost", "bytes of pings that no client read"),
        CounterRow("vehicle_stops", "times the vehicle stopped because no set point came"),
    ),
    "record": (
        CounterRow("messages", "messages written", trouble=False),
        CounterRow("segments", "files begun", trouble=False),
        CounterRow("dropped_messages", "messages dropped: the disk was full, or too slow for "
                   "`record.queue_mb`"),
        *(CounterRow(f"missed_{topic}", f"`{topic}` messages that never came: gaps in `seq`")
          for topic in ("ping", "pose", "detections", "obstacles", "clearance", "truth", "vehicle", "set-point", "raw",
                        "health")),
        CounterRow("oversized_messages", "messages longer than 32 MB, not written"),
        CounterRow("write_failed", "failed attempts to write", trouble=False),
        CounterRow("deleted_segments", "files deleted on a full disk: `record.when_full`", trouble=False),
    ),
    RECORDER: (
        CounterRow("pings", "pings written", trouble=False),
        CounterRow("contacts", "changes of obstacles written", trouble=False),
        CounterRow("poses", "poses written: 20 a second", trouble=False),
        CounterRow("lost_pings", "pings never recorded, by gaps in `seq`"),
        CounterRow("lost_poses", "poses never recorded, likewise"),
        CounterRow("lost_lists", "obstacle lists never recorded, likewise"),
        CounterRow("unfit_pings", "pings that s7k cannot carry, such as samples of scale `db`"),
        CounterRow("unfit_contacts", "obstacles that s7k cannot carry"),
        CounterRow("unfit_poses", "poses that s7k cannot carry"),
        CounterRow("utc_steps", "steps of UTC by more than 1 s: the recording keeps the UTC that it began with"),
        CounterRow("contacts_without_pose", "changes not written yet, without the vehicle's pose"),
        *(CounterRow(f"bad_{topic}", f"malformed `{topic}` messages, among the lost ones too")
          for topic in ("ping", "obstacles", "pose")),
    ),
    RECORDINGS: (
        CounterRow("corrupt_frames", "ARIS: malformed frames; clips: frames equal to the one before"),
        CounterRow("truncated_frames", "ARIS, clips: truncated frames"),
        CounterRow("corrupt_pings", "unusable images"),
        CounterRow("other_messages", "other messages, and items of a log"),
        CounterRow("garbage_bytes", "Oculus: bytes that belong to no message"),
    ),
    OWN_RECORDINGS: (
        CounterRow("torn", "truncated files, read up to the last complete record"),
        CounterRow("bad_chunks", "unusable chunks: wrong checksum, unknown compression or too large"),
        CounterRow("bad_records", "records that contradict themselves"),
        CounterRow("overlong", "records longer than any written"),
        CounterRow("unknown_channels", "messages that are not messages of ODS"),
        CounterRow("unreadable_segments", "files that are not recordings"),
        CounterRow(
            "segments_without_utc", "files whose metadata another program left out: their times are not UTC"
        ),
        CounterRow("left_out", "metadata and attachments beyond 48 MB"),
    ),
    REPLAY: (
        CounterRow("missing_pings", "detections whose ping was not recorded"),
        CounterRow("missing_detections", "lists whose detections were not recorded"),
        CounterRow("missing_lists", "lists published but not recorded, by gaps in `seq`"),
        CounterRow("missing_poses", "poses known on board but not recorded"),
        CounterRow("failed_pings", "pings that the pipeline cannot process"),
        CounterRow("refused_orders", "orders executed on board, but refused here"),
        CounterRow("pipeline_restarts", "restarts of the pipeline", trouble=False),
        CounterRow("tracker_restarts", "restarts of the tracker with the former state", trouble=False),
        CounterRow("tracker_anew", "restarts of the tracker without it", trouble=False),
    ),
    SIM_DEVICES: (
        CounterRow("frames", "CAN adapter: frames passed on", trouble=False),
        CounterRow("garbage", "CAN adapter: lines that are neither frame nor command"),
        CounterRow("dropped", "CAN adapter: frames that a port did not accept"),
        CounterRow("refused", "CAN adapter: frames sent by a port that is not on the bus"),
        CounterRow("unsent", "INS, vehicle: frames that the bus did not accept"),
        CounterRow("unread", "INS, vehicle: times the bus could not be read"),
        CounterRow("short_set_points", "vehicle: set points too short, not obeyed"),
    ),
}  # fmt: skip


def _of_bus(process: str) -> list[CounterRow]:
    """Return what a process's sockets count: topics that it reads, health that it watches, requests that it answers."""
    row = PROCESSES[process]
    topics = [] if row.raw else [*row.reads, *([bus.HEALTH] if row.watches else [])]
    dropped = [CounterRow(f"dropped_{topic}", f"`{topic}` messages dropped: newer ones waited") for topic in topics]
    bad = [CounterRow(f"bad_{topic}", f"malformed `{topic}` messages", logged=True) for topic in topics]
    requests = [CounterRow(f"bad_{row.answers}", "requests that are malformed or too long")] if row.answers else []
    return dropped + bad + requests


COUNTERS: dict[str, dict[str, CounterRow]] = {
    where: {row.name: row for row in [*rows, *(_of_bus(where) if where in PROCESSES else [])]}
    for where, rows in _OWN.items()
}
"""By who counts, and by name."""


def logged_names(where: str) -> frozenset[str]:
    """Return the counters whose first count is worth a line in the log."""
    return frozenset(row.name for row in COUNTERS[where].values() if row.logged)


def trouble_names(where: str) -> frozenset[str]:
    """Return the counters that mean trouble."""
    return frozenset(row.name for row in COUNTERS[where].values() if row.trouble)


def refuse_unknown(where: str, names: Iterable[str]) -> None:
    """Raise LookupError for a counter without a row; only in tests, whose environment says so: `REFUSE`."""
    unknown = set(names) - COUNTERS[where].keys()
    if unknown and REFUSE in os.environ:
        raise LookupError(f"{where} counts {', '.join(sorted(unknown))}: no row in {__name__}")
