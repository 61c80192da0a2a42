#include "client_agent/source/bag/bag_imu.h"

#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client_agent/source/lists/imu_list.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr char kNoBagImu[] = "0";  // ?imu=0

std::vector<const BagTopic*> ImuTopics(const BagContents& contents) {
  std::vector<const BagTopic*> topics;
  for (const BagTopic& topic : contents.topics) {
    if (topic.IsImu() && topic.messages > 0) topics.push_back(&topic);
  }
  return topics;
}

std::string ListTopics(const std::vector<const BagTopic*>& topics, absl::string_view before) {
  if (topics.empty()) return "none";
  return absl::StrJoin(topics, ", ", [&](std::string* text, const BagTopic* topic) {
    absl::StrAppend(text, before, topic->name);
  });
}

// Returns null where none is to be taken.
absl::StatusOr<const BagTopic*> ChooseTopic(const BagImuQuery& query,
                                            const std::vector<const BagTopic*>& topics,
                                            SourceRemarks& remarks) {
  const std::string& named = query.options.imu;
  if (!named.empty()) {
    for (const BagTopic* const topic : topics) {
      if (topic->name == named) return topic;
    }
    return absl::InvalidArgumentError(absl::StrCat(
        query.options.path, ": ?imu=", named,
        ": no topic of sensor_msgs/Imu with messages; there are ", ListTopics(topics, "")));
  }
  if (topics.empty() && query.of_rig.has_value()) {
    remarks.left_out.push_back(
        "the rig's IMU, of which the bag has no samples (no topic of sensor_msgs/Imu)");
  }
  if (topics.size() > 1) {
    remarks.left_out.push_back(
        absl::StrCat("what an IMU measured: there are several topics, say which by ",
                     ListTopics(topics, "?imu=")));
  }
  return topics.size() == 1 ? topics[0] : nullptr;
}

// Returns why nobody knows where it sits; or puts it into `imu`.
std::string PlaceImu(const BagImuQuery& query, const BagTopic& topic, StatedImu& imu) {
  if (query.of_rig.has_value()) {
    imu = *query.of_rig;
    return "";
  }
  const std::optional<Rigid3d> imu_from_camera =
      query.tree.TargetFromSource(topic.imu_frame_id, query.camera_frame_id);
  if (imu_from_camera.has_value() && topic.imu_frame_id != query.camera_frame_id) {
    imu.imu_from_camera = *imu_from_camera;
    return "";
  }
  const std::string why =
      topic.imu_frame_id == query.camera_frame_id
          ? absl::StrCat("its frame is the camera's, '", topic.imu_frame_id, "'")
      : query.tree.empty() ? std::string("there is no /tf_static")
                           : absl::StrCat("/tf_static has no way from frame '",
                                          query.camera_frame_id, "' to '", topic.imu_frame_id, "'");
  return absl::StrCat("nobody says where it sits (", why,
                      "): give a rig file with a block imu: (?rig=FILE, docs/rig.md)");
}

// Tells what is not taken of the topic.
void TellUnread(const std::string& from, const BagTopic& topic, SourceRemarks& remarks) {
  if (topic.unreadable > 0) {
    remarks.findings.push_back(
        {FindingLevel::kWarning, "imu-unreadable",
         absl::StrCat(from, ": ", topic.unreadable, " of ", topic.messages,
                      " messages of the IMU are not whole, or hold a value that is no number: they "
                      "are left out")});
  }
  if (topic.of_other_frames > 0) {
    remarks.findings.push_back(
        {FindingLevel::kWarning, "imu-two-frames",
         absl::StrCat(from, ": ", topic.of_other_frames, " of ", topic.messages,
                      " messages are in another frame than '", topic.imu_frame_id,
                      "', the first one's, and are left out: record each IMU on a topic of its "
                      "own")});
  }
}

}  // namespace

absl::StatusOr<std::optional<BagImu>> FindBagImu(const BagContents& contents,
                                                 const BagImuQuery& query, SourceRemarks& remarks) {
  if (query.options.imu == kNoBagImu) return std::nullopt;
  ASSIGN_OR_RETURN(const BagTopic* const topic, ChooseTopic(query, ImuTopics(contents), remarks));
  if (topic == nullptr) return std::nullopt;
  BagImu imu;
  imu.from = absl::StrCat(query.options.path, ": ", topic->name);
  std::string why = PlaceImu(query, *topic, imu.stated);
  if (query.has_drives) why = "the bag holds several drives, whose times overlap";
  if (!why.empty() && !query.options.imu.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(imu.from, ": the IMU can't be taken: ", why));
  }
  if (!why.empty()) {
    remarks.left_out.push_back(absl::StrCat(topic->name, ": what the IMU measured: ", why));
    return std::nullopt;
  }
  TellUnread(imu.from, *topic, remarks);
  for (const ImuMessage& message : topic->measured) {
    imu.samples.push_back(message.sample);
    if (query.by_recording_time) imu.samples.back().timestamp_ns = message.recorded_ns;
  }
  if (imu.samples.size() < 2) {
    return absl::InvalidArgumentError(
        absl::StrCat(imu.from, ": holds ", imu.samples.size(),
                     " messages of an IMU that can be read; ?imu=0 plays without it"));
  }
  RETURN_IF_ERROR(PutInOrder(imu.from, imu.samples, remarks.findings));
  return imu;
}

}  // namespace corbslam::client_agent
