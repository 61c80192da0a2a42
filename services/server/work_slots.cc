#include "services/server/work_slots.h"

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace corbslam::services {
namespace {

size_t Find(const std::map<std::string, size_t>& counts, const std::string& name) {
  const auto found = counts.find(name);
  return found == counts.end() ? 0 : found->second;
}

void Decrease(const std::string& name, std::map<std::string, size_t>& counts) {
  const auto found = counts.find(name);
  if (found != counts.end() && --found->second == 0) counts.erase(found);
}

}  // namespace

absl::Status WorkSlots::TooMuch(absl::string_view whose, size_t count) const {
  return absl::ResourceExhaustedError(
      absl::StrCat(whose, " has ", count, " ", limits_.what,
                   " under way or waiting, which is the limit; try again when one has ended"));
}

absl::StatusOr<std::shared_ptr<const void>> WorkSlots::Enter(const std::string& caller,
                                                             const std::string& resource) {
  Counts& counts = *counts_;
  absl::MutexLock lock(&counts.mutex);
  if (counts.all >= limits_.all) return TooMuch("this server", counts.all);
  const size_t of_caller = Find(counts.of_caller, caller);
  if (of_caller >= limits_.of_caller) return TooMuch(caller, of_caller);
  const size_t of_resource = Find(counts.of_resource, resource);
  if (of_resource >= limits_.of_resource) return TooMuch(resource, of_resource);
  ++counts.all;
  if (!caller.empty()) ++counts.of_caller[caller];
  if (!resource.empty()) ++counts.of_resource[resource];
  return std::shared_ptr<const void>(&counts, [kept = counts_, caller, resource](const void*) {
    absl::MutexLock ending(&kept->mutex);
    --kept->all;
    Decrease(caller, kept->of_caller);
    Decrease(resource, kept->of_resource);
  });
}

size_t WorkSlots::size() const {
  absl::MutexLock lock(&counts_->mutex);
  return counts_->all;
}

}  // namespace corbslam::services
