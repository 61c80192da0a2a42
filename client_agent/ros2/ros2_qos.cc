#include "client_agent/ros2/ros2_qos.h"

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr int kMostDepth = 10'000;

}  // namespace

absl::Status TakeQosProfile(absl::string_view parameter, Ros2Parameters& parameters, Ros2Qos& qos) {
  std::string profile;
  RETURN_IF_ERROR(
      parameters.Take(parameter, profile, {"SENSOR_DATA", "DEFAULT", "SYSTEM_DEFAULT"}));
  if (profile == "SENSOR_DATA") qos = kSensorData;
  if (profile == "DEFAULT" || profile == "SYSTEM_DEFAULT") qos = kDefaultQos;
  return absl::OkStatus();
}

absl::Status TakeQosOverrides(const std::string& topic, absl::string_view kind,
                              Ros2Parameters& parameters, Ros2Qos& qos) {
  const std::string prefix = absl::StrCat("qos_overrides.", topic, ".", kind, ".");
  std::string reliability;
  std::string durability;
  RETURN_IF_ERROR(
      parameters.Take(prefix + "reliability", reliability, {"reliable", "best_effort"}));
  RETURN_IF_ERROR(
      parameters.Take(prefix + "durability", durability, {"volatile", "transient_local"}));
  RETURN_IF_ERROR(parameters.Take(prefix + "depth", qos.depth, 1, kMostDepth));
  if (!reliability.empty()) qos.reliable = reliability == "reliable";
  if (!durability.empty()) qos.transient_local = durability == "transient_local";
  return absl::OkStatus();
}

DdsQos MakeDdsQos(const Ros2Qos& qos) {
  DdsQos made(dds_create_qos(), &dds_delete_qos);
  dds_qset_history(made.get(), DDS_HISTORY_KEEP_LAST, qos.depth);
  // A writer that waits for a reader's acknowledgements waits at most so long.
  dds_qset_reliability(made.get(),
                       qos.reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       DDS_MSECS(10));
  dds_qset_durability(
      made.get(), qos.transient_local ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  // ROS 2's readers take XCDR1 alone.
  const dds_data_representation_id_t xcdr1 = DDS_DATA_REPRESENTATION_XCDR1;
  dds_qset_data_representation(made.get(), 1, &xcdr1);
  return made;
}

Ros2Qos ReadDdsQos(const dds_qos_t* qos) {
  Ros2Qos read;
  dds_reliability_kind_t reliability = DDS_RELIABILITY_BEST_EFFORT;
  dds_durability_kind_t durability = DDS_DURABILITY_VOLATILE;
  dds_duration_t longest = 0;
  dds_qget_reliability(qos, &reliability, &longest);
  dds_qget_durability(qos, &durability);
  read.reliable = reliability == DDS_RELIABILITY_RELIABLE;
  read.transient_local = durability != DDS_DURABILITY_VOLATILE;
  return read;
}

std::string Describe(const Ros2Qos& qos) {
  return absl::StrCat(qos.reliable ? "reliable" : "best effort", ", ",
                      qos.transient_local ? "transient local" : "volatile");
}

}  // namespace corbslam::client_agent
