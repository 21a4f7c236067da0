"""The pipeline's chain: is every stage known, and does it get through an image?"""

from collections.abc import Iterator

from ods.base.errors import OdsError
from ods.doctor.finding import Finding
from ods.messages import Pose
from ods.pipeline.settings import PipelineSettings

DR_M = 0.05
ZEROS = (0.0, 0.0, 0.0)
AT_REST = Pose(0, 0, 0, ZEROS, (1.0, *ZEROS), ZEROS, ZEROS, ZEROS)


def examine(settings: PipelineSettings) -> Iterator[Finding]:
    """Build the chain and let it process one small made-up image."""
    from ods.pipeline.chain import Chain  # slow to import
    from ods.pipeline.warm_up import made_up_ping

    try:
        ping = made_up_ping("u1", "linear", settings.min_range_m, DR_M)
        Chain(settings).process(ping, pose=AT_REST)
    except (OdsError, ValueError) as error:
        yield Finding("wrong", "pipeline", str(error))
    else:
        yield Finding("good", "pipeline", "all stages are known, their parameters fit, and an image passes")
