#include "client_agent/source/bag/files/bag_file.h"

#include <unistd.h>

#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "client_agent/source/bag/files/bag_bytes.h"
#include "client_agent/source/bag/files/mcap_file.h"
#include "client_agent/source/bag/files/ros1_file.h"
#include "client_agent/source/bag/files/sqlite_file.h"
#include "client_agent/source/bag/files/unpack_file.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr absl::string_view kAnyRosbag = "#ROSBAG V";
constexpr absl::string_view kZstdMagic("\x28\xB5\x2F\xFD", 4);
constexpr uint64_t kMagicBytes = 16;
constexpr size_t kMostNameBytes = 300;

absl::Status NoBag(const std::string& path, absl::string_view first) {
  if (first.empty()) return absl::InvalidArgumentError(absl::StrCat(path, ": an empty file"));
  if (absl::StartsWith(first, kAnyRosbag)) {
    const absl::string_view line = first.substr(0, first.find('\n'));
    return absl::InvalidArgumentError(absl::StrCat(
        path, ": a bag of the format '", CleanName(line),
        "', and 2.0 is read: rewrite it with 'rosbag fix', or 'rosbag migrate' of ROS 1"));
  }
  return absl::InvalidArgumentError(
      absl::StrCat(path,
                   ": at 0: begins neither as a ROS 1 bag (#ROSBAG V2.0) nor as MCAP nor as SQLite "
                   "(.db3)"));
}

// `name` is the bag's own file, `bytes` are of what it holds.
absl::StatusOr<std::unique_ptr<BagFile>> OpenUnpacked(std::unique_ptr<const BagBytes> bytes,
                                                      const std::string& path,
                                                      absl::string_view first) {
  const std::string name = bytes->name();
  if (absl::StartsWith(first, kMcapMagic)) return MakeMcapFile(std::move(bytes));
  if (absl::StartsWith(first, kRos1Magic)) return MakeRos1File(std::move(bytes));
  if (absl::StartsWith(first, kSqliteMagic)) return OpenSqliteFile(path, name);
  return NoBag(name, first);
}

absl::StatusOr<std::unique_ptr<BagFile>> OpenPackedFile(const std::string& path,
                                                        const std::string& name) {
  ASSIGN_OR_RETURN(std::unique_ptr<const BagBytes> bytes, BagBytes::Open(path, name));
  ASSIGN_OR_RETURN(const std::string first, bytes->ReadUpTo(0, kMagicBytes));
  return OpenUnpacked(std::move(bytes), path, first);
}

}  // namespace

absl::StatusOr<std::unique_ptr<BagFile>> OpenBagFile(const std::string& path) {
  ASSIGN_OR_RETURN(std::unique_ptr<const BagBytes> bytes, BagBytes::Open(path));
  ASSIGN_OR_RETURN(const std::string first, bytes->ReadUpTo(0, kMagicBytes));
  if (!absl::StartsWith(first, kZstdMagic)) return OpenUnpacked(std::move(bytes), path, first);
  ASSIGN_OR_RETURN(const std::string unpacked, UnpackZstdFile(*bytes));
  auto file = OpenPackedFile(unpacked, path);
  unlink(unpacked.c_str());  // Who has opened it keeps it.
  return file;
}

std::string PlainTypeName(absl::string_view type) {
  return CleanName(absl::StrReplaceAll(type, {{"/msg/", "/"}}));
}

std::string CleanName(absl::string_view name) {
  std::string clean(name.substr(0, kMostNameBytes));
  for (char& letter : clean) {
    if (!absl::ascii_isprint(static_cast<unsigned char>(letter))) letter = '?';
  }
  return clean;
}

BagEncoding EncodingOfName(absl::string_view name) {
  if (name == "cdr") return BagEncoding::kCdr;
  if (name == "ros1") return BagEncoding::kRos1;
  return BagEncoding::kOther;
}

}  // namespace corbslam::client_agent
