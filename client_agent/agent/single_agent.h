// Implements Agent: composes sensor, tracking, mapping, loop closing and memory management.
#ifndef CORBSLAM_CLIENT_AGENT_AGENT_SINGLE_AGENT_H_
#define CORBSLAM_CLIENT_AGENT_AGENT_SINGLE_AGENT_H_

#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "client_agent/agent/after_work.h"
#include "client_agent/agent/agent.h"
#include "client_agent/agent/hand_over.h"
#include "client_agent/agent/local_map_session.h"
#include "client_agent/agent/picture_maker.h"
#include "client_agent/agent/share_shedding.h"
#include "client_agent/agent/smooth_pose.h"
#include "client_agent/far/far_maps.h"
#include "client_agent/link/store_link.h"
#include "client_agent/map/map_history.h"
#include "client_agent/source_checks/input_watch.h"
#include "client_agent/upload/spooled_map.h"
#include "slam/inertial/inertial_odometry.h"
#include "slam/util/bounded_sample.h"

namespace corbslam::client_agent {

class SingleAgent : public Agent {
 public:
  SingleAgent(const AgentOptions& options, std::unique_ptr<Sensor> sensor,
              const SensorCalibration& calibration, const RecordedCamera& recorded_camera,
              std::shared_ptr<const Vocabulary> vocabulary, Uplink* uplink,
              std::unique_ptr<Spool> spool, absl::StatusOr<SpooledMap> spooled_map);
  ~SingleAgent() override;

  absl::StatusOr<TrackingResult> Track(const SensorImages& images) override;
  absl::Status UsePause() override;
  void BeginLocalMap() override;
  void Step() override;
  absl::Status Finish(absl::Duration timeout) override;
  AgentStatus GetStatus() const override;
  AgentTimings GetTimings() const override;
  std::vector<TrajectoryPose> LocalTrajectory() const override;
  Map CopyMap() const override;
  std::optional<NearMap> GetNearMap(const NearMapLimits& limits) const override;

 private:
  // `global_from_local` is where the new local map lies until the map store says it.
  // `spooled_map`: what the local map is made of, where an earlier process began it.
  // `goes_on`: it lies in the frame of the one before.
  void OpenLocalMap(const std::optional<Similarity3d>& global_from_local = std::nullopt,
                    const SpooledMap* spooled_map = nullptr, bool goes_on = false);
  // Before the first frame: begins a new local map where the frames' time goes back to before what
  // is resumed.
  void CheckTimeGoesOn(int64_t timestamp_ns);
  void NoteResumed(const TrackingResult& result);
  void NoteNotResumed(const std::string& why);
  // Without a map store, earlier local maps come back from the spool; null: they don't.
  std::unique_ptr<FarMaps> MakeFarMaps(bool has_uplink);
  // Null: no pictures go up.
  std::unique_ptr<PictureMaker> MakePictureMaker(const SensorCalibration& calibration);
  void KeepForReturn(const LocalMapSession& session) const;
  void LookForFar(const TrackingResult& result) const;
  void FollowOrders();
  void Follow(const ChangedLimits& limits);
  void Watch(const Features& features);
  // By patches where that is enough, else by the pictures' features.
  absl::StatusOr<TrackingResult> FindPose(const SensorImages& images);
  // Tells tracking what the IMU says of the frame, and learns from what tracking found.
  void ExpectByImu(const SensorImages& images);
  void LearnByImu(TrackingResult& result);
  // Returns where the local map in use lies, for a pose that was found after so many corrections.
  std::optional<Similarity3d> GlobalFromLocal(uint64_t corrections = SharedInbox::kNewest) const;
  // The local map of one camera alone has no metres; in others' map a robot has theirs.
  bool HasMetres() const;
  bool GlobalHasMetres() const;
  // Has a keyframe's picture serve tracking, and people.
  absl::Status KeepPicture(KeyframeId keyframe, const SensorImages& images);
  // Gives up those of others' local maps that contradict the camera from this frame on.
  void LeaveOutContradicting();
  void SayFinding(SourceFinding finding);
  // Asks where the frame was that was tracked last, if it is lost or its map is in no place.
  // `is_placed`: the link says where the map lies.
  void AskForPlace(const TrackingResult& result, bool is_placed);
  bool WantsToAsk(bool is_lost, bool is_placed) const;
  void UseAnswer();
  // Returns whether what the map store found told the robot something.
  bool Use(const PlaceAnswer& answer);
  void Record(const TrackingResult& result, double tracking_ms, bool is_placed);
  void RecordPose(const TrackingResult& result) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Has mapping and loop closing end beside tracking, which goes on in another local map.
  void EndLocalMap();
  // Goes on in a new local map where the one in use is full and the frame is fit for it.
  void HandOverIfFull(const TrackingResult& result);
  // Lets go of what others made and is far, before anything of the robot's own goes. Returns false
  // where that is of no use now.
  bool ShedOthers(const TrackingResult& result, uint64_t map_bytes);
  HandOverEvidence GatherEvidence() const;
  void HandOver(const HandedFrame& handed);
  void WarnOfLateLink(uint64_t map_bytes);
  LocalMapSession& current() const { return *current_session_; }
  // Keeps the results of local maps that ended, once nobody reads these any more.
  struct FinishedMaps {
    OwnItems items;
    LoopCloserCounts loops;
    std::vector<TrajectoryPose> trajectory;
  };
  using Sessions = std::vector<std::shared_ptr<const LocalMapSession>>;

  // Lets go of local maps that ended and that the link has told to their end, oldest first. That
  // takes longer than a frame has: it is done beside tracking.
  void LetGoOfFinished();
  // Keeps the results of the oldest session, whose map does not change any more, and frees it.
  void LetGoOf(std::shared_ptr<const LocalMapSession> session);

  const AgentOptions options_;
  const SensorKind kind_;
  const absl::Time created_;
  const std::unique_ptr<Sensor> sensor_;
  InputWatch input_watch_;
  const std::shared_ptr<const Camera> camera_;
  const std::shared_ptr<const Vocabulary> vocabulary_;
  std::mt19937_64 random_;
  std::shared_ptr<LocalMapSession> current_session_;
  // A frame that has its pose, told already, and may be worth keeping.
  std::optional<std::pair<SensorImages, TrackingResult>> undescribed_;
  SmoothPose smooth_pose_;
  std::optional<InertialOdometry> inertial_;  // Nullopt: the rig has no IMU.
  int tracked_in_a_row_ = 0;
  bool warned_of_late_link_ = false;
  uint64_t max_map_bytes_;  // AgentOptions::max_map_bytes, or what orders said since.
  ShareShedder shedder_;
  bool mapping_paused_ = false;  // By the orders for the newest frame.
  ShareMode share_mode_;         // AgentOptions::share, or what orders said since.
  // While the camera is sought in a local map that an earlier process began.
  struct Resuming {
    std::optional<int64_t> ended_ns;  // The time of its last frame.
    std::optional<int64_t> began_ns;  // The time of this process's first.
  };
  std::optional<Resuming> resuming_;
  SampleLog tracking_ms_;
  SampleLog local_ba_ms_;

  mutable absl::Mutex mutex_;
  // The last one is in use; the maps of the others are still read by the link.
  Sessions sessions_ ABSL_GUARDED_BY(mutex_);
  bool letting_go_ ABSL_GUARDED_BY(mutex_) = false;  // Of the oldest one.
  FinishedMaps finished_ ABSL_GUARDED_BY(mutex_);
  // The frames of the sessions' local maps.
  std::vector<TrackedFrame> tracked_frames_ ABSL_GUARDED_BY(mutex_);
  AgentStatus status_ ABSL_GUARDED_BY(mutex_);
  // True: status_ has a pose in the local map in use.
  bool has_pose_ ABSL_GUARDED_BY(mutex_) = false;
  int64_t points_matched_ ABSL_GUARDED_BY(mutex_) = 0;
  int64_t foreign_points_matched_ ABSL_GUARDED_BY(mutex_) = 0;
  // Where the local map in use lies until the map store says it: by the local map before it, or by
  // what the store found of one of its frames.
  std::optional<Similarity3d> presumed_global_from_local_ ABSL_GUARDED_BY(mutex_);
  absl::Time first_frame_ ABSL_GUARDED_BY(mutex_) = absl::InfiniteFuture();
  PlaceInquiry inquiry_;
  // The link reads the sessions' maps, so that it is destroyed before them.
  std::unique_ptr<StoreLink> link_;
  const std::unique_ptr<FarMaps> far_;            // Uses the link.
  const std::unique_ptr<PictureMaker> pictures_;  // Likewise.
  AfterWork after_work_;                          // Uses all of the above.
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_AGENT_SINGLE_AGENT_H_
