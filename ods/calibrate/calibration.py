"""`ods calibrate`: how the sonar is mounted, from a recording of one fixed object (docs/assess/calibrate.md)."""

from argparse import Namespace

from ods.base.errors import OdsError
from ods.base.geodesy import LocalFrame
from ods.base.settings_file import load
from ods.calibrate.fit import calibrate
from ods.calibrate.model import HeadPoses
from ods.calibrate.pose_history import history_of
from ods.calibrate.report import lines, results_of
from ods.calibrate.sightings import echoes_of
from ods.config import OnboardConfig
from ods.offline.source import recorded_source
from ods.pipeline import offline


def run(args: Namespace) -> None:
    """Print mounting angles and latency with their uncertainty. Raises OdsError where the recording shows nothing."""
    settings = load(args.config, OnboardConfig)
    frame = LocalFrame(settings.site.latitude_deg, settings.site.longitude_deg)
    recording = recorded_source(args.file, site=frame)
    history, begin_ns = history_of(recording.poses)
    found = (result.detections for result in offline.detect_pings(recording.pings, settings.pipeline))
    fit = calibrate(echoes_of(found, begin_ns), HeadPoses(history, settings.sonar.mounting), args.depth)
    if not any(result.known for result in results_of(fit).values()):
        raise OdsError("this recording determines neither yaw, pitch nor latency: see docs/assess/calibrate.md")
    for line in lines(fit, settings.sonar.mounting, settings.sonar.latency_ms):
        print(line)
