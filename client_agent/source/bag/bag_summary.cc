#include "client_agent/source/bag/bag_summary.h"

#include <algorithm>
#include <memory>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/time/time.h"
#include "client_agent/source/bag/bag_contents.h"
#include "client_agent/source/bag/bag_reader.h"
#include "client_agent/source/bag/picture_topic.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

double SecondsBetween(int64_t first_ns, int64_t last_ns) {
  return 1e-9 * (static_cast<double>(last_ns) - static_cast<double>(first_ns));
}

std::string NoteOf(const BagTopic& topic, const std::vector<PictureTopic>& pictures) {
  for (const PictureTopic& picture : pictures) {
    if (picture.topic != &topic) continue;
    if (!picture.problem.empty()) return picture.problem;
    const cv::Size size = picture.form.size;
    return absl::StrFormat("%s%s %dx%d, frame '%s', %s", picture.is_depth ? "depth, " : "",
                           picture.form.encoding, size.width, size.height, picture.frame_id,
                           picture.info.has_value()
                               ? absl::StrCat("calibrated by ", picture.info_topic)
                               : "no CameraInfo");
  }
  if (topic.IsCameraInfo()) return "calibration";
  if (topic.IsImu()) return absl::StrCat("an IMU's, frame '", topic.imu_frame_id, "'");
  if (topic.IsFixedTransforms()) return "where the cameras sit";
  return "not used";
}

BagTopicSummary Summarise(const BagTopic& topic, const std::vector<PictureTopic>& pictures) {
  BagTopicSummary row{topic.name,  topic.type, topic.encoding_name,    topic.messages,
                      topic.bytes, 0,          NoteOf(topic, pictures)};
  const double duration_s = SecondsBetween(topic.first_ns, topic.last_ns);
  if (topic.messages > 1 && duration_s > 0) {
    row.rate_hz = static_cast<double>(topic.messages - 1) / duration_s;
  }
  return row;
}

std::string TimeText(int64_t time_ns) {
  return absl::FormatTime("%Y-%m-%d %H:%M:%S UTC", absl::FromUnixNanos(time_ns),
                          absl::UTCTimeZone());
}

}  // namespace

absl::StatusOr<BagSummary> SummariseBag(const BagOptions& options) {
  ASSIGN_OR_RETURN(const std::shared_ptr<const BagContents> contents,
                   ReadBagContents(options.path));
  BagSummary summary;
  summary.format = contents->recording->format();
  summary.files = contents->recording->file_count();
  summary.messages = contents->messages;
  summary.first_ns = contents->first_ns;
  summary.last_ns = contents->last_ns;
  summary.notes = contents->recording->notes();
  const std::vector<PictureTopic> pictures = LookAtPictures(*contents);
  for (const BagTopic& topic : contents->topics) {
    summary.topics.push_back(Summarise(topic, pictures));
  }
  const auto reader = OpenBagContents(contents, options);
  if (!reader.ok()) {
    summary.lacking = std::string(reader.status().message());
    return summary;
  }
  summary.played = DescribeInLines((*reader)->description());
  summary.findings = (*reader)->description().remarks.findings;
  return summary;
}

std::string FormatBagSummary(const BagSummary& summary) {
  std::string text = absl::StrFormat(
      "%s, %d file%s: %d messages on %d topic%s, %.1f s from %s\n", summary.format, summary.files,
      summary.files == 1 ? "" : "s", summary.messages, summary.topics.size(),
      summary.topics.size() == 1 ? "" : "s", SecondsBetween(summary.first_ns, summary.last_ns),
      TimeText(summary.first_ns));
  size_t name = 0;
  size_t type = 0;
  for (const BagTopicSummary& topic : summary.topics) {
    name = std::max(name, topic.name.size());
    type = std::max(type, topic.type.size());
  }
  for (const BagTopicSummary& topic : summary.topics) {
    absl::StrAppend(&text,
                    absl::StrFormat("  %-*s  %-*s  %7d  %7.2f Hz  %s\n", static_cast<int>(name),
                                    topic.name, static_cast<int>(type), topic.type, topic.messages,
                                    topic.rate_hz, topic.note));
  }
  for (const std::string& note : summary.notes) absl::StrAppend(&text, "note: ", note, "\n");
  if (!summary.lacking.empty()) {
    return absl::StrCat(text, "nothing can be played: ", summary.lacking, "\n");
  }
  absl::StrAppend(&text, "played as it is:\n");
  for (const auto& [what, value] : summary.played) {
    absl::StrAppend(&text, "  ", what, ": ", value, "\n");
  }
  for (const SourceFinding& finding : summary.findings) {
    absl::StrAppend(&text, "  warning: ", finding.text, " [", finding.code, "]\n");
  }
  return text;
}

}  // namespace corbslam::client_agent
