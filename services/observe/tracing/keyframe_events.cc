#include "services/observe/tracing/keyframe_events.h"

#include <cstdint>
#include <nlohmann/json.hpp>

#include "absl/strings/str_format.h"

namespace corbslam::services {
namespace {

using Json = nlohmann::ordered_json;

// Returns an id of 64 bits, as viewers keep them. The constant is odd, so that no two keyframes of
// a local map have the same.
uint64_t RowId(KeyframeId keyframe) {
  return keyframe.local_map.value + (keyframe.index + uint64_t{1}) * 0x9e3779b97f4a7c15u;
}

}  // namespace

std::string TraceId(KeyframeId keyframe) {
  return absl::StrFormat("%016x%016x", keyframe.local_map.value, keyframe.index);
}

std::string ToTraceLine(const KeyframeEvent& event, int process) {
  const Json line = {{"name", std::string(event.name)},
                     {"cat", "keyframe"},
                     {"ph", "n"},
                     {"id2", {{"global", absl::StrFormat("0x%x", RowId(event.keyframe))}}},
                     {"pid", process},
                     {"tid", 1},
                     {"ts", absl::ToUnixMicros(event.time)},
                     {"args",
                      {{"trace", TraceId(event.keyframe)},
                       {"keyframe", ToString(event.keyframe)},
                       {"mission", event.mission},
                       {"agent", event.agent}}}};
  return line.dump();
}

std::string ProcessNameLine(absl::string_view name, int process) {
  const Json line = {{"name", "process_name"},
                     {"ph", "M"},
                     {"pid", process},
                     {"tid", 1},
                     {"args", {{"name", std::string(name)}}}};
  return line.dump();
}

int ProcessNumber(absl::string_view name) {
  // This is FNV-1a, cut to the range of positive ints.
  uint32_t hash = 2166136261u;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
  return static_cast<int>(hash & 0x7fffffffu);
}

}  // namespace corbslam::services
