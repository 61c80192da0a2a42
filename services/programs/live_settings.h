// Has a robot run with the settings that its map store has for it, from its start on and as they
// change.
#ifndef CORBSLAM_SERVICES_PROGRAMS_LIVE_SETTINGS_H_
#define CORBSLAM_SERVICES_PROGRAMS_LIVE_SETTINGS_H_

#include <grpcpp/channel.h>

#include <functional>
#include <future>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "client_agent/agent/agent_orders.h"
#include "services/client/remote/store_route.h"
#include "services/programs/robot/frame_rate_limit.h"
#include "services/programs/settings_book.h"
#include "services/programs/settings_flags.h"

namespace corbslam::services {

struct LiveSettingsOptions {
  SettingsFlags files;
  std::string mission;
  std::string agent;
  // The robot's own flags, and which of them somebody gave.
  SettableFlags flags;
  std::set<std::string> given;
  // What wants changes while the robot runs.
  std::shared_ptr<client_agent::AgentOrders> orders;
  std::shared_ptr<FrameRateLimit> rate;
  // Says whether the robot can run with such flags.
  std::function<absl::Status(const SettableFlags&)> check;
  // Returns the limits that such flags are for a robot that began with others.
  std::function<client_agent::ChangedLimits(const SettableFlags& begun, const SettableFlags&)>
      limits;
};

// Asks the store, on a thread of its own and for ten seconds at most, which settings it has for the
// robot; none without a route or without a key to check them with. Whoever waits for the answer
// waits so long.
std::future<absl::StatusOr<v1::RobotSettingsList>> AskForSettings(std::shared_ptr<StoreRoute> route,
                                                                  const SettingsFlags& files,
                                                                  const std::string& mission,
                                                                  const std::string& agent);

// Says in the log which settings it takes from where, and which it refuses and why: nothing of that
// ends a robot. A file of keys that can't be read is read again whenever settings come.
// Thread-safe.
class LiveSettings {
 public:
  explicit LiveSettings(LiveSettingsOptions options);

  // Before the robot begins, and once AgentOrders knows its camera: returns the flags that it is to
  // begin with, by what it kept and by what the store answered, if it did.
  SettableFlags Begin(const absl::StatusOr<v1::RobotSettingsList>& told);
  // Gives the robot, which is there now, the mask that it begins with.
  void GiveMask();
  // Takes what the store tells later.
  void OnSettings(const v1::RobotSettingsList& list);

  // Returns what the statistics say: versions, settings taken, refusals; null without keys.
  nlohmann::ordered_json Report() const;

 private:
  void ReadKeys() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status Fits(const v1::RobotSettings& of_all, const v1::RobotSettings& own) const;
  // Takes settings and returns whether the robot is to run with other flags than before. `keep`:
  // they are for the file, too.
  bool Take(const v1::RobotSettingsList& list, bool keep) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Keep() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Refuse(const absl::Status& why) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void SetMask() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void SayWhatNeedsARestart() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const LiveSettingsOptions options_;
  mutable absl::Mutex mutex_;
  // Nullopt: no keys are trusted.
  std::optional<SettingsBook> book_ ABSL_GUARDED_BY(mutex_);
  bool said_ignored_ ABSL_GUARDED_BY(mutex_) = false;
  SettableFlags flags_ ABSL_GUARDED_BY(mutex_);  // With what was taken.
  SettableFlags begun_ ABSL_GUARDED_BY(mutex_);  // Those that the robot began with.
  std::vector<std::string> lines_ ABSL_GUARDED_BY(mutex_);
  std::set<std::string> refused_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_LIVE_SETTINGS_H_
