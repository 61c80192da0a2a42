#include "client_agent/source/source_kinds.h"

#include <algorithm>

#include "absl/base/thread_annotations.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/synchronization/mutex.h"
#include "client_agent/source/frame_stream.h"
#include "client_agent/source/source_spec.h"

namespace corbslam::client_agent {
namespace {

struct Registry {
  absl::Mutex mutex;
  std::vector<SourceKind> kinds ABSL_GUARDED_BY(mutex);
};

// Returns the registry, which lives as long as the program.
Registry& TheRegistry() {
  static auto& registry = *new Registry;
  return registry;
}

std::vector<SourceKind> AllKinds() {
  Registry& registry = TheRegistry();
  absl::MutexLock lock(&registry.mutex);
  return registry.kinds;
}

}  // namespace

absl::StatusOr<std::unique_ptr<FrameStream>> KindSettings::OpenLive(
    const absl::Notification& /*stop*/) const {
  return absl::UnimplementedError(absl::StrCat(kind(), ": is no live camera"));
}

void RegisterSourceKind(SourceKind kind) {
  const std::vector<absl::string_view> taken = RecordedLayoutNames();
  if (std::find(taken.begin(), taken.end(), kind.name) != taken.end()) return;
  Registry& registry = TheRegistry();
  absl::MutexLock lock(&registry.mutex);
  for (const SourceKind& known : registry.kinds) {
    if (known.name == kind.name) return;
  }
  registry.kinds.push_back(std::move(kind));
}

std::optional<SourceKind> FindSourceKind(absl::string_view name) {
  for (SourceKind& kind : AllKinds()) {
    if (kind.name == name) return std::move(kind);
  }
  return std::nullopt;
}

std::vector<std::string> KnownSourceKinds() {
  std::vector<std::string> names;
  for (const absl::string_view layout : RecordedLayoutNames()) names.emplace_back(layout);
  for (SourceKind& kind : AllKinds()) names.push_back(std::move(kind.name));
  return names;
}

std::string SourceUsage() {
  std::vector<std::string> usages;
  for (const absl::string_view layout : RecordedLayoutNames()) {
    usages.push_back(absl::StrCat(layout, ":DIR"));
  }
  for (SourceKind& kind : AllKinds()) usages.push_back(std::move(kind.usage));
  const std::string last = std::move(usages.back());
  usages.pop_back();
  return absl::StrCat(absl::StrJoin(usages, ", "), " or ", last);
}

}  // namespace corbslam::client_agent
