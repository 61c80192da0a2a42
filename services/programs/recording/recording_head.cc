#include "services/programs/recording/recording_head.h"

#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "services/programs/recording/calibration_json.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kFormat = 1;

Json ToJson(const RecordedFlags& flags) {
  return {{"mission", flags.mission},
          {"agent", flags.agent},
          {"seed", flags.seed},
          {"features", flags.features},
          {"threads", flags.solver_threads},
          {"pace", flags.pace},
          {"joined", flags.joined},
          {"vocabulary", flags.vocabulary},
          {"localise_only", flags.localise_only},
          {"resumes", flags.resumes},
          {"max_map_bytes", flags.max_map_bytes}};
}

Json ToJson(const RecordedCounts& counts) {
  return {{"frames", counts.frames},
          {"left_out", counts.left_out},
          {"dropped", counts.dropped},
          {"tracked", counts.tracked}};
}

RecordedFlags FlagsOf(const Json& json) {
  RecordedFlags flags;
  flags.mission = json.at("mission");
  flags.agent = json.at("agent");
  flags.seed = json.at("seed");
  flags.features = json.at("features");
  flags.solver_threads = json.at("threads");
  flags.pace = json.at("pace");
  flags.joined = json.at("joined");
  flags.vocabulary = json.at("vocabulary");
  // Older recordings don't say these.
  flags.localise_only = json.value("localise_only", false);
  flags.resumes = json.value("resumes", false);
  flags.max_map_bytes = json.value("max_map_bytes", uint64_t{0});
  return flags;
}

RecordedCounts CountsOf(const Json& json) {
  return {json.at("frames"), json.at("left_out"), json.at("dropped"), json.at("tracked")};
}

absl::StatusOr<RecordingHead> HeadOf(const Json& json) {
  if (const int format = json.at("recording"); format != kFormat) {
    return absl::DataLossError(absl::StrCat("it is of format ", format, ", this program reads ",
                                            kFormat, ": take the program that recorded it"));
  }
  RecordingHead head;
  head.version = json.at("version");
  head.source = json.at("source");
  head.started = json.at("started");
  head.flags = FlagsOf(json.at("flags"));
  ASSIGN_OR_RETURN(head.calibration, CalibrationFromJson(json.at("calibration")));
  head.has_mask = json.at("mask");
  if (json.contains("mask_checksum")) head.mask_checksum = json.at("mask_checksum").get<uint32_t>();
  head.counts = CountsOf(json.at("counts"));
  head.finished = json.at("finished");
  head.ended = json.at("ended");
  return head;
}

}  // namespace

std::string FormatHead(const RecordingHead& head) {
  Json json = {{"recording", kFormat},        {"version", head.version},
               {"source", head.source},       {"started", head.started},
               {"flags", ToJson(head.flags)}, {"calibration", services::ToJson(head.calibration)},
               {"mask", head.has_mask},       {"counts", ToJson(head.counts)},
               {"finished", head.finished},   {"ended", head.ended}};
  if (head.mask_checksum.has_value()) json["mask_checksum"] = *head.mask_checksum;
  // A source's name need not be UTF-8.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

absl::StatusOr<RecordingHead> ParseHead(const std::string& text) {
  try {
    return HeadOf(Json::parse(text));
  } catch (const Json::exception& error) {
    return absl::DataLossError(error.what());
  }
}

}  // namespace corbslam::services
