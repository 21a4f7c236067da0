"""ROS 2 message definitions that a ROS installation has only with extra packages, as texts without their comments.

What they say is the interface that others read and is given as it is: marine_acoustic_msgs 2.0.2 (University of
Washington and others, BSD-3-Clause), nav2_dynamic_msgs 0.0.1 at its commit e1b0d92 (Nav2, Apache-2.0), radar_msgs 0.2.2
(Apache-2.0).
"""

PROJECTED_SONAR_IMAGE = "marine_acoustic_msgs/msg/ProjectedSonarImage"
PING_INFO = "marine_acoustic_msgs/msg/PingInfo"
SONAR_IMAGE_DATA = "marine_acoustic_msgs/msg/SonarImageData"
OBSTACLE = "nav2_dynamic_msgs/msg/Obstacle"
OBSTACLE_ARRAY = "nav2_dynamic_msgs/msg/ObstacleArray"
RADAR_TRACK = "radar_msgs/msg/RadarTrack"
RADAR_TRACKS = "radar_msgs/msg/RadarTracks"

DEFINITIONS: dict[str, str] = {
    PING_INFO: """float32 frequency
float32 sound_speed
float32[] tx_beamwidths
float32[] rx_beamwidths
""",
    SONAR_IMAGE_DATA: """bool is_bigendian
uint32 DTYPE_UINT8=0
uint32 DTYPE_INT8=1
uint32 DTYPE_UINT16=2
uint32 DTYPE_INT16=3
uint32 DTYPE_UINT32=4
uint32 DTYPE_INT32=5
uint32 DTYPE_UINT64=6
uint32 DTYPE_INT64=7
uint32 DTYPE_FLOAT32=8
uint32 DTYPE_FLOAT64=9
uint32 dtype
uint32 beam_count
uint8[] data
""",
    PROJECTED_SONAR_IMAGE: """std_msgs/Header header
PingInfo ping_info
geometry_msgs/Vector3[] beam_directions
float32[] ranges
SonarImageData image
""",
    OBSTACLE: """unique_identifier_msgs/UUID uuid
float32 score
geometry_msgs/Point position
geometry_msgs/Vector3 velocity
geometry_msgs/Vector3 size
float64[9] position_covariance
float64[9] velocity_covariance
""",
    OBSTACLE_ARRAY: """std_msgs/Header header
Obstacle[] obstacles
""",
    RADAR_TRACK: """uint16 NO_CLASSIFICATION=0
uint16 STATIC=1
uint16 DYNAMIC=2
unique_identifier_msgs/UUID uuid
geometry_msgs/Point position
geometry_msgs/Vector3 velocity
geometry_msgs/Vector3 acceleration
geometry_msgs/Vector3 size
uint16 classification
float32[6] position_covariance
float32[6] velocity_covariance
float32[6] acceleration_covariance
float32[6] size_covariance
""",
    RADAR_TRACKS: """std_msgs/Header header
RadarTrack[] tracks
""",
}
