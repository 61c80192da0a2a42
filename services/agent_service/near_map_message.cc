#include "services/agent_service/near_map_message.h"

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "services/convert/errors.h"
#include "services/convert/geometry.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::NearMap;

namespace {

using Coordinates = google::protobuf::RepeatedField<float>;

void WritePoints(const std::vector<Eigen::Vector3f>& points, Coordinates* proto) {
  proto->Reserve(static_cast<int>(3 * points.size()));
  for (const Eigen::Vector3f& point : points) proto->Add(point.begin(), point.end());
}

absl::StatusOr<std::vector<Eigen::Vector3f>> ReadPoints(absl::string_view field,
                                                        const Coordinates& proto) {
  if (proto.size() % 3 != 0) {
    return absl::InvalidArgumentError(
        absl::StrCat(field, " has ", proto.size(), " numbers, must be three for each point"));
  }
  std::vector<Eigen::Vector3f> points;
  points.reserve(static_cast<size_t>(proto.size() / 3));
  for (int i = 0; i < proto.size(); i += 3) {
    points.emplace_back(proto[i], proto[i + 1], proto[i + 2]);
    if (points.back().allFinite()) continue;
    return absl::InvalidArgumentError(absl::StrCat(field, "[", i, "] is not finite"));
  }
  return points;
}

absl::StatusOr<LocalMapId> ReadLocalMap(const std::string& text) {
  LocalMapId id;
  if (text.size() == 16 && absl::SimpleHexAtoi(text, &id.value) && id.IsValid()) return id;
  return absl::InvalidArgumentError(
      absl::StrCat("local_map is \"", text, "\", must be 16 hexadecimal digits, not all 0"));
}

absl::StatusOr<NearMap::NearKeyframe> ReadKeyframe(const v1::NearKeyframe& proto) {
  NearMap::NearKeyframe keyframe;
  ASSIGN_OR_RETURN(keyframe.id.local_map, ReadLocalMap(proto.local_map()));
  keyframe.id.index = proto.index();
  ASSIGN_OR_RETURN(keyframe.local_from_camera, FromProto(proto.local_from_camera()));
  keyframe.shared = proto.shared();
  return keyframe;
}

}  // namespace

void ToProto(const NearMap& near, v1::WatchAgentMapResponse* proto) {
  proto->set_timestamp_ns(near.timestamp_ns);
  proto->set_local_map(ToString(near.local_map));
  proto->mutable_centre()->Add(near.centre.begin(), near.centre.end());
  WritePoints(near.own_points, proto->mutable_own_points());
  WritePoints(near.shared_points, proto->mutable_shared_points());
  for (const NearMap::NearKeyframe& keyframe : near.keyframes) {
    v1::NearKeyframe* added = proto->add_keyframes();
    added->set_local_map(ToString(keyframe.id.local_map));
    added->set_index(keyframe.id.index);
    ToProto(keyframe.local_from_camera, added->mutable_local_from_camera());
    added->set_shared(keyframe.shared);
  }
  proto->set_truncated(near.truncated);
}

absl::StatusOr<NearMap> FromProto(const v1::WatchAgentMapResponse& proto) {
  NearMap near;
  near.timestamp_ns = proto.timestamp_ns();
  ASSIGN_OR_RETURN(near.local_map, ReadLocalMap(proto.local_map()));
  if (proto.centre_size() != 3) {
    return absl::InvalidArgumentError(
        absl::StrCat("centre has ", proto.centre_size(), " numbers, must be 3"));
  }
  near.centre = {proto.centre(0), proto.centre(1), proto.centre(2)};
  if (const absl::Status centre = CheckPosition(near.centre); !centre.ok()) {
    return Locate(centre, "centre");
  }
  ASSIGN_OR_RETURN(near.own_points, ReadPoints("own_points", proto.own_points()));
  ASSIGN_OR_RETURN(near.shared_points, ReadPoints("shared_points", proto.shared_points()));
  for (const v1::NearKeyframe& told : proto.keyframes()) {
    absl::StatusOr<NearMap::NearKeyframe> keyframe = ReadKeyframe(told);
    if (!keyframe.ok()) {
      return Locate(keyframe.status(), absl::StrCat("keyframes[", near.keyframes.size(), "]"));
    }
    near.keyframes.push_back(*std::move(keyframe));
  }
  near.truncated = proto.truncated();
  return near;
}

}  // namespace corbslam::services
