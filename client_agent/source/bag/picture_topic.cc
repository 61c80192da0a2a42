#include "client_agent/source/bag/picture_topic.h"

#include <algorithm>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client_agent/source/bag/topic_names.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::client_agent {
namespace {

constexpr size_t kFirstMessages = 10;

struct LookedAt {
  RosPictureForm form;
  std::string frame_id;
};

template <typename Message>
LookedAt Of(const Message& message) {
  return {FormOf(message), message.header.frame_id};
}

absl::StatusOr<LookedAt> LookAt(const BagContents& contents, const BagTopic& topic,
                                const RecordedPlace& place) {
  ASSIGN_OR_RETURN(const std::string bytes, contents.recording->Read(place));
  if (topic.type == kImageType) {
    ASSIGN_OR_RETURN(const RosImage image, ReadRosImage(topic.encoding, bytes));
    return Of(image);
  }
  ASSIGN_OR_RETURN(const RosCompressedImage image, ReadRosCompressedImage(topic.encoding, bytes));
  return Of(image);
}

// Of what could be depth, tells it by its name where its encoding leaves that open.
bool IsDepth(const PictureTopic& picture) {
  if (!picture.form.can_be_depth || SaysNoDepth(picture.base)) return false;
  const bool is_open = absl::StartsWithIgnoreCase(picture.form.encoding, "mono16");
  return !is_open || SaysDepth(picture.base);
}

std::string WhyNotPlayed(const PictureTopic& picture, const absl::Status& error) {
  const BagTopic& topic = *picture.topic;
  if (topic.encoding == BagEncoding::kOther) {
    return absl::StrCat("messages are serialised as '", topic.encoding_name,
                        "', read are cdr and ros1");
  }
  if (topic.messages == 0) return "no messages";
  if (topic.pictures.empty() || !error.ok()) {
    return absl::StrCat("none of its first messages can be read",
                        error.ok() ? "" : absl::StrCat(": ", error.message()));
  }
  if (picture.form.can_be_grey || picture.form.can_be_depth) return "";
  return absl::StrCat(picture.is_compressed ? "format '" : "encoding '", picture.form.encoding,
                      "' is not read");
}

PictureTopic LookAtTopic(const BagContents& contents, const BagTopic& topic) {
  PictureTopic picture;
  picture.topic = &topic;
  picture.base = BaseTopic(topic.name);
  picture.is_compressed = topic.type == kCompressedImageType;
  absl::Status error;
  for (size_t i = 0; i < std::min(kFirstMessages, topic.pictures.size()); ++i) {
    absl::StatusOr<LookedAt> first = LookAt(contents, topic, topic.pictures[i].place);
    error = first.status();
    if (!first.ok()) continue;
    picture.form = first->form;
    picture.frame_id = first->frame_id;
    if (picture.form.can_be_grey || picture.form.can_be_depth) break;
  }
  picture.problem = WhyNotPlayed(picture, error);
  picture.is_depth = IsDepth(picture);
  return picture;
}

absl::StatusOr<RosCameraInfo> ReadInfo(const BagContents& contents, const BagTopic& topic,
                                       const RecordedPlace& place) {
  ASSIGN_OR_RETURN(const std::string bytes, contents.recording->Read(place));
  return ReadRosCameraInfo(topic.encoding, bytes);
}

bool IsSameCamera(const RosCameraInfo& a, const RosCameraInfo& b) {
  return a.width_px == b.width_px && a.height_px == b.height_px && a.d == b.d && a.k == b.k &&
         a.r == b.r && a.p == b.p && a.distortion_model == b.distortion_model;
}

void FindCameraInfo(const BagContents& contents, PictureTopic& picture) {
  for (const std::string& name : CameraInfoTopics(picture.base)) {
    if (UseCameraInfo(contents, name, picture).ok()) return;
  }
  // Elsewhere, in the same frame, where that is one alone.
  if (picture.frame_id.empty()) return;
  const BagTopic* only = nullptr;
  for (const BagTopic& topic : contents.topics) {
    if (!topic.IsCameraInfo() || topic.kept.empty()) continue;
    const auto info = ReadInfo(contents, topic, topic.kept.front());
    if (!info.ok() || info->header.frame_id != picture.frame_id) continue;
    if (only != nullptr) return;
    only = &topic;
  }
  if (only != nullptr) (void)UseCameraInfo(contents, only->name, picture);
}

template <typename Decode>
absl::StatusOr<cv::Mat> Named(const BagContents& contents, const PictureTopic& picture,
                              int64_t timestamp_ns, const RecordedPlace& place, Decode decode) {
  absl::StatusOr<std::string> bytes = contents.recording->Read(place);
  if (!bytes.ok()) return bytes.status();  // It names file and offset.
  absl::StatusOr<cv::Mat> decoded = decode(*bytes);
  if (decoded.ok()) return decoded;
  return absl::InvalidArgumentError(absl::StrCat(contents.recording->path(), ": ", picture.name(),
                                                 ": the message of ", FormatSeconds(timestamp_ns),
                                                 " s: ", decoded.status().message()));
}

// `convert` makes the picture of a message of either type.
template <typename Convert>
absl::StatusOr<cv::Mat> ReadAs(Convert convert, const BagContents& contents,
                               const PictureTopic& picture, const RecordedPlace& place,
                               int64_t timestamp_ns) {
  const BagEncoding encoding = picture.topic->encoding;
  return Named(contents, picture, timestamp_ns, place,
               [&](const std::string& bytes) -> absl::StatusOr<cv::Mat> {
                 if (!picture.is_compressed) {
                   ASSIGN_OR_RETURN(const RosImage image, ReadRosImage(encoding, bytes));
                   return convert(image);
                 }
                 ASSIGN_OR_RETURN(const RosCompressedImage image,
                                  ReadRosCompressedImage(encoding, bytes));
                 return convert(image);
               });
}

}  // namespace

std::vector<PictureTopic> LookAtPictures(const BagContents& contents) {
  std::vector<PictureTopic> pictures;
  for (const BagTopic& topic : contents.topics) {
    if (!topic.HasPictures()) continue;
    pictures.push_back(LookAtTopic(contents, topic));
    FindCameraInfo(contents, pictures.back());
  }
  return pictures;
}

absl::Status UseCameraInfo(const BagContents& contents, const std::string& name,
                           PictureTopic& picture) {
  const BagTopic* const topic = contents.Find(name);
  if (topic == nullptr || !topic->IsCameraInfo() || topic->kept.empty()) {
    return absl::NotFoundError(absl::StrCat(contents.recording->path(), ": no sensor_msgs/",
                                            "CameraInfo on topic ", name));
  }
  absl::StatusOr<RosCameraInfo> info = ReadInfo(contents, *topic, topic->kept.front());
  if (!info.ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat(contents.recording->path(), ": ", name, ": ", info.status().message()));
  }
  picture.info_changes =
      std::any_of(topic->kept.begin() + 1, topic->kept.end(), [&](const RecordedPlace& place) {
        const auto later = ReadInfo(contents, *topic, place);
        return later.ok() && !IsSameCamera(*info, *later);
      });
  picture.info = *std::move(info);
  picture.info_topic = name;
  return absl::OkStatus();
}

TransformTree ReadFixedTransforms(const BagContents& contents) {
  TransformTree tree;
  for (const BagTopic& topic : contents.topics) {
    if (!topic.IsFixedTransforms()) continue;
    for (const RecordedPlace& place : topic.kept) {
      const absl::StatusOr<std::string> bytes = contents.recording->Read(place);
      if (!bytes.ok()) continue;
      const auto transforms = ReadRosTransforms(topic.encoding, *bytes);
      if (!transforms.ok()) continue;
      for (const RosTransform& transform : *transforms) tree.Add(transform);
    }
  }
  return tree;
}

absl::StatusOr<cv::Mat> ReadBagGrey(const BagContents& contents, const PictureTopic& picture,
                                    const RecordedPlace& place, int64_t timestamp_ns) {
  return ReadAs([](const auto& image) { return GreyOf(image); }, contents, picture, place,
                timestamp_ns);
}

absl::StatusOr<cv::Mat> ReadBagDepth(const BagContents& contents, const PictureTopic& picture,
                                     const RecordedPlace& place, int64_t timestamp_ns) {
  return ReadAs([](const auto& image) { return DepthOf(image); }, contents, picture, place,
                timestamp_ns);
}

std::string DescribeTopic(const PictureTopic& picture) {
  std::string text = absl::StrCat(picture.name(), " (", picture.form.encoding);
  if (picture.form.size.area() > 0) {
    absl::StrAppend(&text, ", ", picture.form.size.width, "x", picture.form.size.height);
  }
  return absl::StrCat(text, picture.problem.empty() ? "" : absl::StrCat("; ", picture.problem),
                      ")");
}

}  // namespace corbslam::client_agent
