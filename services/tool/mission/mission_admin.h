// Does what operators do with the missions of a running map store.
#ifndef CORBSLAM_SERVICES_TOOL_MISSION_MISSION_ADMIN_H_
#define CORBSLAM_SERVICES_TOOL_MISSION_MISSION_ADMIN_H_

#include <grpcpp/channel.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "corbslam/v1/map_store_service.grpc.pb.h"

namespace corbslam::services {

// Speaks to one map store. Thread-safe. Errors are those of the store, with the call that met them,
// and those of files, with their names.
class MissionAdmin {
 public:
  // Called with the number of bytes so far.
  using Progress = std::function<void(uint64_t bytes)>;

  explicit MissionAdmin(const std::shared_ptr<grpc::Channel>& channel);

  absl::StatusOr<std::vector<v1::Mission>> List();
  absl::StatusOr<v1::Mission> Get(const std::string& mission);
  absl::StatusOr<v1::Mission> Create(const v1::Mission& mission);
  absl::StatusOr<v1::Mission> Update(const v1::UpdateMissionRequest& request);
  // Gets what Update would change, has `change` make the request of it, and does so again where
  // somebody else changed the mission meanwhile; ABORTED once that has happened five times.
  absl::StatusOr<v1::Mission> Change(
      const std::string& mission,
      const std::function<absl::StatusOr<v1::UpdateMissionRequest>(const v1::Mission& now)>&
          change);
  // These are of robots' settings; `name` is a mission's or an agent's.
  absl::StatusOr<v1::RobotSettingsList> GetSettings(const std::string& name);
  absl::StatusOr<v1::RobotSettingsList> SetSettings(const std::string& name,
                                                    const v1::SignedRobotSettings& settings);
  // Writes the mission to a file, durably, and returns its size in bytes. ALREADY_EXISTS if there
  // is a file of that name. A file under this name is always whole.
  absl::StatusOr<uint64_t> BackUp(const std::string& mission, const std::string& path,
                                  const Progress& on_progress = nullptr);
  // Gives the mission's backup piece by piece to `sink`, which may end it with an error of its own.
  absl::Status ReadBackup(const std::string& mission,
                          const std::function<absl::Status(const std::string& piece)>& sink);
  absl::StatusOr<v1::Mission> Restore(const std::string& path, const std::string& mission,
                                      const Progress& on_progress = nullptr);
  // Has the mission leave memory, and returns what is said of it then.
  absl::StatusOr<v1::Mission> Sleep(const std::string& mission);
  // Deletes closed local maps of an agent, or says what would go.
  absl::StatusOr<v1::ForgetLocalMapsResponse> Forget(const v1::ForgetLocalMapsRequest& request);
  // Returns how many local maps went with the mission.
  absl::StatusOr<uint32_t> Delete(const std::string& mission);

 private:
  std::unique_ptr<v1::MapStore::Stub> stub_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_MISSION_MISSION_ADMIN_H_
