#include <array>
#include <bit>
#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"
#include "foxglove/point_cloud.pb.h"
#include "services/tool/export/mcap/foxglove_values.h"
#include "services/tool/export/mcap/frame_names.h"
#include "services/tool/export/mcap/recorded_scene.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

static_assert(std::endian::native == std::endian::little, "the points' numbers are little-endian");

using foxglove::PackedElementField;

// Three floats and four bytes a point.
constexpr uint32_t kStride = 16;

foxglove::PointCloud BeginCloud(LocalMapId island, uint64_t time_ns) {
  foxglove::PointCloud cloud;
  ToFoxglove(time_ns, cloud.mutable_timestamp());
  cloud.set_frame_id(IslandFrame(island));
  ToFoxglove(Rigid3d::Identity(), cloud.mutable_pose());
  cloud.set_point_stride(kStride);
  uint32_t offset = 0;
  for (const char* name : {"x", "y", "z", "red", "green", "blue", "alpha"}) {
    PackedElementField* field = cloud.add_fields();
    field->set_name(name);
    field->set_offset(offset);
    field->set_type(offset < 12 ? PackedElementField::FLOAT32 : PackedElementField::UINT8);
    offset += offset < 12 ? 4 : 1;
  }
  return cloud;
}

void AddPoint(const Eigen::Vector3f& position, const Colour& colour, std::string& data) {
  std::array<char, kStride> bytes{};
  std::memcpy(bytes.data(), position.data(), 12);
  const std::array<uint8_t, 4> rgba = {colour.red, colour.green, colour.blue, 255};
  std::memcpy(bytes.data() + 12, rgba.data(), rgba.size());
  data.append(bytes.data(), bytes.size());
}

// The points of one robot in one island, written whenever there are enough for a message.
class CloudWriter {
 public:
  CloudWriter(std::string topic, const Colour& colour, foxglove::PointCloud cloud, uint64_t time_ns,
              FoxgloveChannels& channels)
      : topic_(std::move(topic)),
        colour_(colour),
        cloud_(std::move(cloud)),
        time_ns_(time_ns),
        channels_(channels) {}

  absl::Status Add(const Eigen::Vector3f& position) {
    AddPoint(position, colour_, *cloud_.mutable_data());
    return cloud_.data().size() < kPointsInACloud * kStride ? absl::OkStatus() : Write();
  }
  // Writes what is left; a cloud without points, too, where there was none.
  absl::Status Finish() {
    return cloud_.data().empty() && written_ > 0 ? absl::OkStatus() : Write();
  }

 private:
  absl::Status Write() {
    ++written_;
    RETURN_IF_ERROR(
        channels_.Write(absl::StrCat(topic_, NumberSuffix(written_)), time_ns_, cloud_));
    cloud_.mutable_data()->clear();
    return absl::OkStatus();
  }

  const std::string topic_;
  const Colour colour_;
  foxglove::PointCloud cloud_;
  const uint64_t time_ns_;
  FoxgloveChannels& channels_;
  size_t written_ = 0;
};

}  // namespace

absl::Status WritePoints(const ToldMap& map, const RobotColours& colours, uint64_t time_ns,
                         FoxgloveChannels& channels) {
  for (const auto& [id, island] : map.islands) {
    std::map<std::string, CloudWriter> robots;
    for (const auto& [point, position] : island.points) {
      const std::string robot = map.AgentOf(point.local_map);
      auto writer = robots.find(robot);
      if (writer == robots.end()) {
        const std::string topic =
            absl::StrCat(MapTopic(robot, "points"), IslandSuffix(id, island.in_global_frame));
        writer = robots
                     .try_emplace(robot, topic, ColourOf(robot, colours), BeginCloud(id, time_ns),
                                  time_ns, channels)
                     .first;
      }
      RETURN_IF_ERROR(writer->second.Add(position));
    }
    for (auto& [robot, writer] : robots) RETURN_IF_ERROR(writer.Finish());
  }
  return absl::OkStatus();
}

}  // namespace corbslam::services
