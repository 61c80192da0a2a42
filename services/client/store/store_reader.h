// Reads a mission from a running map store.
#ifndef CORBSLAM_SERVICES_CLIENT_STORE_STORE_READER_H_
#define CORBSLAM_SERVICES_CLIENT_STORE_STORE_READER_H_

#include <grpcpp/channel.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "corbslam/v1/map_store_service.grpc.pb.h"
#include "services/client/store/map_streams.h"
#include "services/client/store/served_mission.h"
#include "services/client/store/told_map.h"
#include "services/security/security_options.h"
#include "slam/camera/recorded_camera.h"

namespace corbslam::services {

// Returns a connected channel to the map store at HOST:PORT. INVALID_ARGUMENT for what is no
// address. UNAVAILABLE if no map store answers, with the cause: within a second or so if the cause
// is certain (nobody listens, TLS on one side, another server); if the network may be slow, that is
// logged, and the error comes after `patience`.
absl::StatusOr<std::shared_ptr<grpc::Channel>> ConnectToStore(
    const std::string& address, const SecurityOptions& security,
    absl::Duration patience = absl::Seconds(10));

// The same, to the map store that has the mission: the one at HOST:PORT, or where that one sends. A
// mission that nobody has is the first one's. UNAVAILABLE also if the other store is not reached.
absl::StatusOr<std::shared_ptr<grpc::Channel>> ConnectToStoreOf(
    const std::string& mission, const std::string& address, const SecurityOptions& security,
    absl::Duration patience = absl::Seconds(10));

// Reads one mission. Thread-safe. Each call has a deadline of its own. Errors are those of the
// store, with the call that met them.
class StoreReader {
 public:
  StoreReader(std::shared_ptr<grpc::Channel> channel, std::string mission);

  // The channel to the store, for what is asked without this.
  const std::shared_ptr<grpc::Channel>& channel() const { return channel_; }

  absl::StatusOr<v1::GetStatisticsResponse> Statistics();
  // Returns once everything that came was looked up, verified, fused and adjusted.
  absl::Status WaitUntilFused(absl::Duration timeout);
  // Returns the mission's agents by their own names; none before the first.
  absl::StatusOr<std::map<std::string, v1::MissionAgent>> ListAgents();
  // Returns the mission's local maps as they arrived; none before the first.
  absl::StatusOr<std::vector<v1::LocalMap>> ListLocalMaps();
  // Returns how many frames, tracked or lost, each agent has reported so far; empty before the
  // first.
  absl::StatusOr<std::map<std::string, uint64_t>> CountReportedFrames();

  // Which local maps a global trajectory is of: those in the global frame alone, or all, each in
  // the frame of its island.
  enum class Reach { kGlobalFrame, kAllIslands };

  // FAILED_PRECONDITION if the store doesn't know the frame that `poses_of` wants. `unposed`, if
  // not null, is told of how many frames there is no pose.
  absl::StatusOr<ServedTrajectory> ReadTrajectory(const std::string& agent,
                                                  v1::TrajectoryFrame frame,
                                                  PosesOf poses_of = PosesOf::kRecordedCamera,
                                                  Reach reach = Reach::kGlobalFrame,
                                                  UnposedFrames* unposed = nullptr);
  // Returns the island in the global frame.
  absl::StatusOr<ServedMap> ReadGlobalMap();
  // Returns all islands with their points.
  absl::StatusOr<ToldMap> ReadMap();
  // Gives the map as it is, with its points or without, as messages for ToldMap; the last one does
  // not say `continues`. An error of `take` ends it.
  absl::Status ReadPresent(bool with_points, const TakeMapMessage& take);
  // Gives the mission's past, at most so many moments, 2 to 1,000, as messages for ToldMap; a
  // moment's last one does not say `continues`. It is as long as the store lets it be: hundreds of
  // megabytes. An error of `take` ends it. UNIMPLEMENTED: the store is older.
  absl::Status ReadPast(uint32_t max_moments, bool with_points, const TakeMapMessage& take);
  // Gives the map, with points or without, as it was at each of at most `max_moments` moments, 2 to
  // 1,000, and as it is in the end; an error of `on_moment` ends it. UNIMPLEMENTED: the store is
  // older.
  using OnMoment = std::function<absl::Status(const ToldMap& map)>;
  absl::Status ReplayMap(uint32_t max_moments, bool with_points, const OnMoment& on_moment);
  // Returns when each of the keyframes that the store has was taken, by its robot's clock.
  absl::StatusOr<std::map<KeyframeId, int64_t>> ReadKeyframeTimes();
  // Returns the events that the store remembers, oldest first. It takes two seconds longer than
  // they take to come. UNIMPLEMENTED: the store is older.
  absl::StatusOr<std::vector<v1::MissionEvent>> ReadEvents();

 private:
  const std::shared_ptr<grpc::Channel> channel_;
  const std::string mission_;
  const std::unique_ptr<v1::MapStore::Stub> stub_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CLIENT_STORE_STORE_READER_H_
