// Bounds work that costs much, in all, by who asks for it and by what it is about.
#ifndef CORBSLAM_SERVICES_SERVER_WORK_SLOTS_H_
#define CORBSLAM_SERVICES_SERVER_WORK_SLOTS_H_

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"

namespace corbslam::services {

// What is done and what waits counts together.
struct WorkLimits {
  std::string what;  // In the plural, for people: "backups".
  size_t all = 0;
  size_t of_caller = 0;
  size_t of_resource = 0;
};

// Counts work. Thread-safe.
class WorkSlots {
 public:
  explicit WorkSlots(WorkLimits limits) : limits_(std::move(limits)) {}

  // Returns what counts as a piece of work until it is destroyed, also after this. An empty name is
  // nobody's, and counts in all alone. RESOURCE_EXHAUSTED names whose limit is met.
  absl::StatusOr<std::shared_ptr<const void>> Enter(const std::string& caller,
                                                    const std::string& resource);
  size_t size() const;

 private:
  absl::Status TooMuch(absl::string_view whose, size_t count) const;

  struct Counts {
    mutable absl::Mutex mutex;
    size_t all ABSL_GUARDED_BY(mutex) = 0;
    std::map<std::string, size_t> of_caller ABSL_GUARDED_BY(mutex);
    std::map<std::string, size_t> of_resource ABSL_GUARDED_BY(mutex);
  };

  const WorkLimits limits_;
  const std::shared_ptr<Counts> counts_ = std::make_shared<Counts>();
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SERVER_WORK_SLOTS_H_
