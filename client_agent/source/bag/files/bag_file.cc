#include "client_agent/source/bag/files/bag_file.h"

#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "client_agent/source/bag/files/bag_bytes.h"
#include "client_agent/source/bag/files/mcap_file.h"
#include "client_agent/source/bag/files/ros1_file.h"
#include "client_agent/source/bag/files/sqlite_file.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr absl::string_view kAnyRosbag = "#ROSBAG V";
constexpr absl::string_view kZstdMagic("\x28\xB5\x2F\xFD", 4);
constexpr uint64_t kMagicBytes = 16;

absl::Status NoBag(const std::string& path, absl::string_view first) {
  if (first.empty()) return absl::InvalidArgumentError(absl::StrCat(path, ": an empty file"));
  if (absl::StartsWith(first, kAnyRosbag)) {
    const absl::string_view line = first.substr(0, first.find('\n'));
    return absl::InvalidArgumentError(absl::StrCat(
        path, ": a bag of the format '", line,
        "', and 2.0 is read: rewrite it with 'rosbag fix', or 'rosbag migrate' of ROS 1"));
  }
  if (absl::StartsWith(first, kZstdMagic)) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": compressed as a whole: unpack it with 'unzstd ", path,
                     "' (bags with compressed chunks or messages are played as they are)"));
  }
  return absl::InvalidArgumentError(
      absl::StrCat(path,
                   ": at 0: begins neither as a ROS 1 bag (#ROSBAG V2.0) nor as MCAP nor as SQLite "
                   "(.db3)"));
}

}  // namespace

absl::StatusOr<std::unique_ptr<BagFile>> OpenBagFile(const std::string& path) {
  ASSIGN_OR_RETURN(std::unique_ptr<const BagBytes> bytes, BagBytes::Open(path));
  ASSIGN_OR_RETURN(const std::string first, bytes->ReadUpTo(0, kMagicBytes));
  if (absl::StartsWith(first, kMcapMagic)) return MakeMcapFile(std::move(bytes));
  if (absl::StartsWith(first, kRos1Magic)) return MakeRos1File(std::move(bytes));
  if (absl::StartsWith(first, kSqliteMagic)) return OpenSqliteFile(path);
  return NoBag(path, first);
}

std::string PlainTypeName(absl::string_view type) {
  return absl::StrReplaceAll(type, {{"/msg/", "/"}});
}

BagEncoding EncodingOfName(absl::string_view name) {
  if (name == "cdr") return BagEncoding::kCdr;
  if (name == "ros1") return BagEncoding::kRos1;
  return BagEncoding::kOther;
}

}  // namespace corbslam::client_agent
