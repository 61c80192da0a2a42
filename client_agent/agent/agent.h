// One robot, the agent: from images to its pose and its map. It is complete without a map store;
// with one, its map goes there and what others made comes back.
#ifndef CORBSLAM_CLIENT_AGENT_AGENT_AGENT_H_
#define CORBSLAM_CLIENT_AGENT_AGENT_AGENT_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "client_agent/agent/activity_watch.h"
#include "client_agent/agent/agent_events.h"
#include "client_agent/agent/agent_orders.h"
#include "client_agent/agent/place_inquiry.h"
#include "client_agent/far/far_maps.h"
#include "client_agent/map/near_map.h"
#include "client_agent/source/source_finding.h"
#include "client_agent/spool/spool.h"
#include "client_agent/tracking/tracking_result.h"
#include "client_agent/upload/feature_selection.h"
#include "client_agent/upload/upload_queue.h"
#include "slam/exchange/uplink.h"
#include "slam/inertial/inertial_odometry.h"
#include "slam/map/map.h"
#include "slam/sensor/sensor.h"
#include "slam/util/bounded_sample.h"
#include "slam/vocabulary/vocabulary.h"

namespace corbslam::client_agent {

struct AgentOptions {
  std::string mission = "default";
  std::string name = "agent";
  // Seed of local map ids and RANSAC samples.
  uint64_t seed = 1;
  // True: all is done on one thread, everything after each frame until idle, with the same result
  // to the bit every time.
  bool deterministic = false;
  SensorOptions sensor;
  int solver_threads = 1;
  // The features of a keyframe that go up.
  FeatureSelection upload_features;
  // Size of the pictures of keyframes that go up for people (PictureEncoder::Make); 0: none do. A
  // deterministic agent, and one that only localises, sends none.
  int picture_width_px = 0;
  // Bytes that batches which the map store has not acknowledged may take in memory.
  size_t max_outbox_bytes = 64 << 20;
  // Bytes that the items of the local map in use may take in memory, others' among them, as
  // EstimateBytes has it; 0: no bound. Beyond, the agent goes on in a new local map and lets go of
  // the old one once the link has told all of it (docs/robot.md): it needs an uplink or a spool.
  uint64_t max_map_bytes = 0;
  // Bounds of the link to the map store, each way; 0: no bound (docs/adr/0019-link-budgets.md).
  uint64_t uplink_bytes_per_second = 0;
  uint64_t downlink_bytes_per_second = 0;
  // What the robot wants to be told of what others mapped.
  ShareScope share;
  // With a spool, what tracking made so long ago outlives the process and a loss of power: half of
  // it is for writing, the rest for the disk (SpoolOptions::sync says how much). 0: the spool has
  // what memory has no room for, and what is left at the end.
  absl::Duration spool_within = absl::ZeroDuration();
  // With spool_within: the agent goes on with the local map that the spool keeps of an earlier
  // process, lost in it at first. Where it recognises no place in it within `resume_wait` of the
  // frames' time, or the spool keeps none, it begins a new one.
  bool resume = false;
  absl::Duration resume_wait = absl::Seconds(10);
  // Makes no map: tracks the camera in what others share, in the mission's global frame, and tells
  // the store nothing but where it was. Needs an uplink.
  bool localise_only = false;
  // Who is asked where a frame was taken, while the robot is lost or does not know where its map
  // lies; null: nobody.
  AskPlace ask_place;
  // Whether anybody will ask for LocalTrajectory. What it returns is held in memory, some 100 bytes
  // a frame.
  bool keep_trajectory = true;
  // What others want of the robot while it runs; null: nobody does.
  std::shared_ptr<AgentOrders> orders;
  // Where the link to the map store notes what happens; null: nowhere. What frames change, whoever
  // gives frames notes (AgentEvents::NoteFrame).
  std::shared_ptr<AgentEvents> events;

  // What the link tells the map store of the robot itself, where that takes it; null: nothing.
  // Whoever gives frames notes them there.
  std::shared_ptr<const ActivityWatch> activity;

  absl::Status Validate() const;
};

// A pose of the sensor's camera. For poses of the camera as it recorded, or of the body, see
// CameraFromWanted (recorded_camera.h) and RecordedCameraOf (sensor.h).
struct TrajectoryPose {
  int64_t timestamp_ns = 0;
  LocalMapId local_map;
  Rigid3d local_from_camera;
};

struct AgentStatus {
  TrackingState state = TrackingState::kNotInitialised;
  LocalMapId local_map;
  // Why the last frame has no pose.
  WhyNoPose why_no_pose = WhyNoPose::kHasOne;
  bool mapping_paused = false;
  // Time and pose of the last tracked frame.
  int64_t timestamp_ns = 0;
  Rigid3d local_from_camera;
  // Where the local map in use lies, as the map store said last. Before it has said so that is
  // where the store found one of its frames (AgentOptions::ask_place) or, after a hand-over, where
  // the local map before lay: the two have one frame.
  std::optional<Similarity3d> global_from_local;
  // As TrackingResult's.
  bool without_metres = false;
  bool global_without_metres = false;

  int frames = 0;
  int tracked = 0;
  int lost = 0;
  int local_maps = 0;
  // Local maps that were begun because the one before was full (AgentOptions::max_map_bytes).
  int hand_overs = 0;
  // About what the local map in use takes in memory.
  uint64_t map_bytes = 0;
  // Own items, over all local maps.
  int keyframes = 0;
  int map_points = 0;
  int loops_closed = 0;
  // Others' keyframes held in the map, and the percentage of tracked points that others made, over
  // all frames tracked while any are held.
  int foreign_keyframes = 0;
  // Shared updates that came in the session that stands, or in the last one.
  uint64_t shared_updates = 0;
  double foreign_points_percent = 0;
  // Loops closed against others' keyframes.
  int foreign_loops_closed = 0;
  // Frames whose place the map store found: by them tracking went on, or it was known where the map
  // lies before fusion said so.
  int places_told = 0;
  // Seconds between the first frame and the first that knew its pose in the mission's global frame.
  std::optional<double> located_after_s;
  // With AgentOptions::resume: whether the local map of an earlier process went on, and how many
  // seconds of frames that took; why not, where it did not. Empty: there was none.
  bool resumed = false;
  std::optional<double> resumed_after_s;
  std::string why_not_resumed;
  // Seconds between Create and the first acknowledged keyframe.
  std::optional<double> first_upload_s;
  UploadStatus upload;
  // What came back of local maps that had left memory, where there is no map store for that.
  FarMapsStatus far;
  // Nullopt: the rig has no IMU.
  std::optional<InertialState> inertial;
  // How often the map went on where the IMU took the camera to be, since no picture said it.
  int bridged = 0;
  // What looked wrong in the sensor's input, in the order in which it was seen.
  SourceFindings input_findings;
};

// How long each frame and each local bundle adjustment took, since the beginning.
struct AgentTimings {
  BoundedSample tracking_ms;
  BoundedSample local_ba_ms;
};

// One robot. One thread at a time may call Track, BeginLocalMap, Step and Finish; the rest is
// thread-safe.
class Agent {
 public:
  virtual ~Agent() = default;

  // `uplink` is not owned and may be null: then nothing is shared; what is mapped goes to the spool
  // all the same. `spool` may be null: then what the map store has not acknowledged ends with the
  // process. Returns INVALID_ARGUMENT where
  // options or calibration are impossible.
  static absl::StatusOr<std::unique_ptr<Agent>> Create(const AgentOptions& options,
                                                       const SensorCalibration& calibration,
                                                       std::shared_ptr<const Vocabulary> vocabulary,
                                                       Uplink* uplink,
                                                       std::unique_ptr<Spool> spool = nullptr);

  // Returns the pose of the camera at one time. With threads it returns once the frame is tracked,
  // whatever mapping does; a deterministic agent then also steps mapping, loop closing and the
  // uplink until idle. Returns INVALID_ARGUMENT where images don't fit the calibration. A frame
  // that can't be tracked is no error: the state says so.
  virtual absl::StatusOr<TrackingResult> Track(const SensorImages& images) = 0;

  // Does what of the newest frame can wait until its pose is used: the features of one that may be
  // worth keeping. To be called after Track; else the next Track does it first. A deterministic
  // agent has done it.
  virtual absl::Status UsePause() = 0;

  // Ends the local map and begins a new one: what follows shares nothing with what was tracked so
  // far but the camera. To be called between two calls of Track.
  virtual void BeginLocalMap() = 0;

  // In deterministic runs, works off what came down the uplink since the last Track.
  virtual void Step() = 0;

  // Returns when all keyframes are mapped, loops are closed, and the map store has acknowledged
  // everything (with an uplink); closes the local map. Returns DEADLINE_EXCEEDED otherwise. Track
  // must not be called afterwards.
  virtual absl::Status Finish(absl::Duration timeout) = 0;

  virtual AgentStatus GetStatus() const = 0;
  // Returns copies of all timings, which is meant for the end.
  virtual AgentTimings GetTimings() const = 0;
  // Returns every tracked frame, by the map as it is now; empty without
  // AgentOptions::keep_trajectory.
  virtual std::vector<TrajectoryPose> LocalTrajectory() const = 0;
  // Returns a copy of the local map in use.
  virtual Map CopyMap() const = 0;
  // Returns what of the local map in use lies around the camera of the newest frame that had a pose
  // in it (FindNearMap); nullopt as long as no frame had one.
  virtual std::optional<NearMap> GetNearMap(const NearMapLimits& limits) const = 0;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_AGENT_AGENT_H_
