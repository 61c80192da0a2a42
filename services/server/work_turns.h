// Whose request is worked on next: no one keeps others waiting for long, however much they ask for.
#ifndef CORBSLAM_SERVICES_SERVER_WORK_TURNS_H_
#define CORBSLAM_SERVICES_SERVER_WORK_TURNS_H_

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/time/time.h"

namespace corbslam::services {

// Orders requests of many missions. Not thread-safe; without a clock of its own.
class WorkTurns {
 public:
  // What may wait, such as adjustments, stands behind all else for so long, and until so many
  // others have begun since one that may wait began: an adjustment has a thread for much longer.
  static constexpr absl::Duration kPatience = absl::Seconds(10);
  static constexpr int kOthersBetween = 4;

  struct Request {
    uint64_t id = 0;
    std::string mission;  // Or who asks, where that is not known.
    bool may_wait = false;
  };

  void Add(Request request, absl::Time now);
  // Takes the next request: of the mission with the fewest that are worked on; of these of the one
  // whose last turn was longest ago; of its own the oldest. There must be one that waits.
  Request Begin(absl::Time now);
  // Notes that a request of the mission has ended.
  void End(const std::string& mission);
  size_t waiting() const { return waiting_.size(); }

 private:
  struct Waiting {
    Request request;
    absl::Time since;
  };
  struct Mission {
    int running = 0;
    int waiting = 0;
    uint64_t last_turn = 0;
  };

  bool GoesBefore(const Waiting& a, const Waiting& b, absl::Time now) const;
  void ForgetIfIdle(const std::string& mission);

  std::vector<Waiting> waiting_;  // In the order in which they came.
  std::map<std::string, Mission> missions_;
  uint64_t turns_ = 0;
  int others_begun_ = 0;  // Since one began that may wait.
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SERVER_WORK_TURNS_H_
