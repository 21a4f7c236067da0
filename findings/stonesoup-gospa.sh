#!/bin/sh
# Stone Soup's GOSPA counts m/s as metres, and a track that is a microsecond late as a miss and a false track.
#
# Version:   stonesoup 1.9
# Behaviour: GOSPAMetric's default measure is the Euclidean distance of whole state vectors, also of [x, vx, y, vy], the
#            state of its own transition models; states are compared only if their times are equal to the microsecond.
# Seen:      right position, velocity 5 m/s off: 5.0; position and velocity right, stamped 1 us late: twice 7.07
#            (c = 10, p = 2: one missed at the first time, one false at the second)
# Expected:  0 for both, by someone who takes c = 10 for 10 m. Neither is hidden: the measure's `mapping` names the
#            components, by default all, and the metric is documented as computed at each time of a track.
# Matters:   scores beside those of other trackers are inflated without a word: use Euclidean(mapping=[0, 2]) and put
#            tracks at the times of the truth before comparing.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check stonesoup==1.9
"$place/venv/bin/python" - <<'END'
import sys
from datetime import datetime, timedelta

from stonesoup.measures import Euclidean
from stonesoup.metricgenerator.ospametric import GOSPAMetric
from stonesoup.types.groundtruth import GroundTruthPath, GroundTruthState
from stonesoup.types.state import State
from stonesoup.types.track import Track

NOW = datetime(2026, 3, 1, 12)


def distances(track_state, late=timedelta(0), **options):
    truth = GroundTruthPath([GroundTruthState([10.0, 0.0, 5.0, 0.0], timestamp=NOW)])
    track = Track([State(track_state, timestamp=NOW + late)])
    metric = GOSPAMetric(p=2, c=10.0, **options)
    tracks, truths = (metric.extract_states([path], True) for path in (track, truth))
    result = metric.compute_over_time(*tracks, *truths)
    results = result.value if isinstance(result.value, list) else [result]
    return [round(float(one.value["distance"]), 2) for one in results]


seen = {
    "velocity 5 m/s off": distances([10.0, 5.0, 5.0, 0.0]),
    "the same by positions": distances([10.0, 5.0, 5.0, 0.0], measure=Euclidean(mapping=[0, 2])),
    "1 us late": distances([10.0, 0.0, 5.0, 0.0], late=timedelta(microseconds=1)),
}
if seen != {"velocity 5 m/s off": [5.0], "the same by positions": [0.0], "1 us late": [7.07, 7.07]}:
    sys.exit(f"changed: GOSPA at each time: {seen}")
print(f"as before: GOSPA at each time: {seen}")
END
