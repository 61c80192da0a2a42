#include "client_agent/source/foreign_files.h"

#include <algorithm>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"

namespace corbslam::client_agent {
namespace {

struct ForeignKind {
  // Endings of such files without the dot, and names that people put before a colon.
  std::vector<absl::string_view> names;
  const char* what;
  const char* advice;
};

constexpr char kPushOrExtract[] =
    "play it with its own player and push its pictures (push:SOCKET, docs/push.md), or write them "
    "out as a folder of one of the layouts";

constexpr char kPlayAsBag[] =
    "name it as bag:FILE, or bag:DIR for a folder of rosbag2 (docs/sources.md); "
    "'corbslam bag info' lists what is in it";

const std::vector<ForeignKind>& Kinds() {
  static const auto& kinds = *new std::vector<ForeignKind>{
      {{"bag", "db3", "rosbag", "rosbag2", "ros", "ros2"}, "a ROS bag", kPlayAsBag},
      {{"mcap"}, "an MCAP recording", kPlayAsBag},
      {{"svo", "svo2", "zed"},
       "a recording of a ZED",
       "write it out with Stereolabs' SVO export as left and right pictures (kitti: with times.txt "
       "and a rig file), or push its pictures (push:SOCKET, docs/push.md)"},
      {{"mp4", "avi", "mov", "mkv", "webm", "m4v", "video"},
       "a film",
       "robots need a stereo pair or depth, with a calibration: two films that run together are "
       "played by GStreamer as \"gst:filesrc location=LEFT ! decodebin || filesrc location=RIGHT ! "
       "decodebin\" with ?rig=FILE, or written out as a folder of pictures (kitti:)"},
      {{"oni", "openni", "openni2"}, "a camera or recording of OpenNI", kPushOrExtract},
      {{"klg"}, "a recording of ElasticFusion's logger", kPushOrExtract},
      {{"rrd"}, "a recording of Rerun", kPushOrExtract},
      {{"zip", "tar", "tgz", "gz", "7z", "xz", "zst"},
       "an archive",
       "unpack it, and name the folder in it"}};
  return kinds;
}

}  // namespace

std::string DescribeForeignFile(absl::string_view name) {
  const std::string lower = absl::AsciiStrToLower(name);
  const size_t dot = lower.rfind('.');
  const std::string word = dot == std::string::npos ? lower : lower.substr(dot + 1);
  for (const ForeignKind& kind : Kinds()) {
    if (std::ranges::find(kind.names, word) == kind.names.end()) continue;
    const bool is_bag = kind.advice == kPlayAsBag;
    return absl::StrCat(kind.what, is_bag ? ": " : ", which is not played as it is: ", kind.advice);
  }
  return "";
}

}  // namespace corbslam::client_agent
