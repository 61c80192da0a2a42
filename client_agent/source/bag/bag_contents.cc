#include "client_agent/source/bag/bag_contents.h"

#include <algorithm>
#include <bit>
#include <map>
#include <tuple>
#include <utility>

#include "absl/strings/match.h"
#include "client_agent/source/bag/messages/ros_messages.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr size_t kMostKept = 1000;
// More frames than that on one topic are no cameras'.
constexpr size_t kMostPublishers = 16;

void Extend(int64_t time_ns, uint64_t messages, int64_t& first_ns, int64_t& last_ns) {
  first_ns = messages == 0 ? time_ns : std::min(first_ns, time_ns);
  last_ns = messages == 0 ? time_ns : std::max(last_ns, time_ns);
}

// Sorts messages into topics as they are scanned.
class ContentsReader {
 public:
  explicit ContentsReader(BagContents& contents) : contents_(contents) {}

  void Take(const ScannedMessage& message, uint32_t file) {
    BagTopic& topic = TopicOf(message.channel);
    Extend(message.recorded_ns, topic.messages, topic.first_ns, topic.last_ns);
    Extend(message.recorded_ns, contents_.messages, contents_.first_ns, contents_.last_ns);
    const RecordedPlace place{file, message.place};
    if (topic.HasPictures()) TakePicture(message, place, topic);
    if (topic.IsImu()) TakeMeasured(message, topic);
    // Of CameraInfo the first, second, fourth and so on: a calibration that changes is seen.
    const bool is_kept = topic.IsFixedTransforms() ||
                         (topic.IsCameraInfo() && std::has_single_bit(topic.messages + 1));
    if (is_kept && topic.kept.size() < kMostKept) topic.kept.push_back(place);
    ++topic.messages;
    ++contents_.messages;
    topic.bytes += message.place.size;
  }
  // Topics without messages are there too.
  void AddOthers() {
    for (size_t i = 0; i < contents_.recording->channels().size(); ++i) TopicOf(i);
  }

 private:
  BagTopic& TopicOf(size_t channel) {
    while (topic_of_channel_.size() <= channel) {
      const BagChannel& next = contents_.recording->channels()[topic_of_channel_.size()];
      const auto [known, is_new] = numbers_.emplace(
          std::tuple(next.topic, next.type, next.encoding_name), contents_.topics.size());
      if (is_new) {
        BagTopic topic;
        topic.name = next.topic;
        topic.type = next.type;
        topic.encoding_name = next.encoding_name;
        topic.encoding = next.encoding;
        contents_.topics.push_back(std::move(topic));
      }
      topic_of_channel_.push_back(known->second);
    }
    return contents_.topics[topic_of_channel_[channel]];
  }
  void TakePicture(const ScannedMessage& message, const RecordedPlace& place, BagTopic& topic) {
    const absl::StatusOr<RosHeader> header = ReadRosHeader(topic.encoding, message.head);
    if (!header.ok()) {
      ++topic.unreadable;
      return;
    }
    const uint32_t publisher = PublisherOf(message.channel, header->frame_id, topic);
    BagPublisher& known = topic.publishers[publisher];
    Extend(message.recorded_ns, known.messages, known.first_ns, known.last_ns);
    ++known.messages;
    topic.pictures.push_back({header->stamp_ns, message.recorded_ns, place, publisher});
  }
  static void TakeMeasured(const ScannedMessage& message, BagTopic& topic) {
    const absl::StatusOr<RosImu> imu = ReadRosImu(topic.encoding, message.head);
    if (!imu.ok() || !imu->angular_velocity_rps.allFinite() ||
        !imu->linear_acceleration_mps2.allFinite()) {
      ++topic.unreadable;
      return;
    }
    if (topic.measured.empty()) topic.imu_frame_id = imu->header.frame_id;
    if (topic.imu_frame_id != imu->header.frame_id) {
      ++topic.of_other_frames;
      return;
    }
    topic.measured.push_back(
        {{imu->header.stamp_ns, imu->angular_velocity_rps, imu->linear_acceleration_mps2},
         message.recorded_ns});
  }
  uint32_t PublisherOf(size_t channel, const std::string& frame_id, BagTopic& topic) {
    std::vector<BagPublisher>& all = topic.publishers;
    for (uint32_t i = 0; i < all.size(); ++i) {
      if (all[i].channel == channel && all[i].frame_id == frame_id) return i;
    }
    if (all.size() < kMostPublishers) {
      BagPublisher added;
      added.channel = channel;
      added.frame_id = frame_id;
      added.node = contents_.recording->channels()[channel].publisher;
      all.push_back(std::move(added));
    }
    return static_cast<uint32_t>(all.size() - 1);
  }

  BagContents& contents_;
  std::map<std::tuple<std::string, std::string, std::string>, size_t> numbers_;
  std::vector<size_t> topic_of_channel_;
};

}  // namespace

bool BagTopic::HasPictures() const { return type == kImageType || type == kCompressedImageType; }

bool BagTopic::IsCameraInfo() const { return type == kCameraInfoType; }

bool BagTopic::IsImu() const { return type == kImuType; }

bool BagTopic::IsFixedTransforms() const {
  return (type == kTransformsType || type == kOldTransformsType) &&
         absl::EndsWith(name, "tf_static");
}

const BagTopic* BagContents::Find(const std::string& name) const {
  const auto found = std::find_if(topics.begin(), topics.end(),
                                  [&](const BagTopic& topic) { return topic.name == name; });
  return found == topics.end() ? nullptr : &*found;
}

absl::StatusOr<std::shared_ptr<const BagContents>> ReadBagContents(const std::string& path) {
  auto contents = std::make_shared<BagContents>();
  ASSIGN_OR_RETURN(contents->recording, BagRecording::Open(path));
  ContentsReader reader(*contents);
  contents->recording->Scan(
      [&](const ScannedMessage& message, uint32_t file) { reader.Take(message, file); });
  reader.AddOthers();
  std::sort(contents->topics.begin(), contents->topics.end(),
            [](const BagTopic& a, const BagTopic& b) {
              return std::tie(a.name, a.type) < std::tie(b.name, b.type);
            });
  return contents;
}

}  // namespace corbslam::client_agent
