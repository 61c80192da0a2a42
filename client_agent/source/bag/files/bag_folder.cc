#include "client_agent/source/bag/files/bag_folder.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client_agent/source/calibration/yaml_fields.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMostBagFiles = 100'000;

bool IsBagName(const std::string& name) {
  for (const char* ending : {".bag", ".db3", ".mcap", ".bag.active", ".db3.zstd", ".mcap.zstd"}) {
    if (absl::EndsWith(name, ending)) return true;
  }
  return false;
}

// Compares names as people count: part_2 before part_10.
bool IsBefore(const std::string& a, const std::string& b) {
  size_t i = 0;
  size_t k = 0;
  while (i < a.size() && k < b.size()) {
    if (absl::ascii_isdigit(static_cast<unsigned char>(a[i])) &&
        absl::ascii_isdigit(static_cast<unsigned char>(b[k]))) {
      const auto end_of = [](const std::string& text, size_t from) {
        return std::min(text.find_first_not_of("0123456789", from), text.size());
      };
      i = std::min(a.find_first_not_of('0', i), end_of(a, i));
      k = std::min(b.find_first_not_of('0', k), end_of(b, k));
      const std::string first = a.substr(i, end_of(a, i) - i);
      const std::string second = b.substr(k, end_of(b, k) - k);
      if (first.size() != second.size()) return first.size() < second.size();
      if (first != second) return first < second;
      i += first.size();
      k += second.size();
      continue;
    }
    if (a[i] != b[k]) return a[i] < b[k];
    ++i;
    ++k;
  }
  return a.size() - i < b.size() - k;
}

absl::StatusOr<BagFolder> ListFolder(const std::string& path) {
  BagFolder folder;
  std::error_code error;
  for (auto entry = fs::directory_iterator(path, error); !error && entry != fs::end(entry);
       entry.increment(error)) {
    if (IsBagName(entry->path().filename().string()))
      folder.files.push_back(entry->path().string());
    if (folder.files.size() > kMostBagFiles) break;
  }
  if (error) return absl::InvalidArgumentError(absl::StrCat(path, ": ", error.message()));
  if (folder.files.empty()) {
    return absl::NotFoundError(
        absl::StrCat(path, ": a folder with neither metadata.yaml nor a .bag, .db3 or .mcap file"));
  }
  std::sort(folder.files.begin(), folder.files.end(), IsBefore);
  folder.notes.push_back(absl::StrCat(
      path,
      ": has no metadata.yaml (a recorder that was killed writes none): the bag files in it (",
      folder.files.size(), ") are read by name"));
  return folder;
}

// Early versions name files with their folder in front.
std::string FileIn(const std::string& directory, const std::string& name) {
  std::error_code ignored;
  std::string path = absl::StrCat(directory, "/", name);
  if (fs::exists(path, ignored)) return path;
  std::string beside = absl::StrCat(directory, "/", fs::path(name).filename().string());
  return fs::exists(beside, ignored) ? beside : path;
}

std::string WordOf(const YAML::Node& node) {
  return node.IsDefined() && node.IsScalar() ? node.Scalar() : "";
}

absl::Status TakeCompression(const YAML::Node& information, const std::string& path,
                             BagFolder& folder) {
  const std::string mode = absl::AsciiStrToUpper(WordOf(information["compression_mode"]));
  if (mode != "MESSAGE") return absl::OkStatus();  // Files say themselves what they are.
  folder.message_compression = absl::AsciiStrToLower(WordOf(information["compression_format"]));
  if (folder.message_compression == "zstd") return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      path, ": compression_format is '", folder.message_compression, "', zstd is unpacked"));
}

absl::Status TakeMetadata(const YAML::Node& file, const std::string& directory,
                          const std::string& path, BagFolder& folder) {
  const YAML::Node information = file.IsMap() ? file["rosbag2_bagfile_information"] : YAML::Node();
  if (!information.IsDefined() || !information.IsMap()) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": rosbag2_bagfile_information is missing"));
  }
  const YAML::Node names = information["relative_file_paths"];
  if (!names.IsDefined() || !names.IsSequence() || names.size() > kMostBagFiles) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": relative_file_paths is no list of files"));
  }
  for (const YAML::Node& name : names) {
    const std::string listed = FileIn(directory, WordOf(name));
    std::error_code ignored;
    if (fs::exists(listed, ignored)) {
      folder.files.push_back(listed);
    } else {
      folder.notes.push_back(absl::StrCat(path, ": lists ", listed, ", which is not there"));
    }
  }
  RETURN_IF_ERROR(TakeCompression(information, path, folder));
  if (!folder.files.empty()) return absl::OkStatus();
  return absl::NotFoundError(
      absl::StrCat(path, ": of the files in relative_file_paths none is there",
                   folder.notes.empty() ? "" : absl::StrCat(" (", folder.notes.front(), ")")));
}

}  // namespace

absl::StatusOr<BagFolder> FindBagFiles(const std::string& path) {
  std::error_code ignored;
  BagFolder folder;
  if (!fs::exists(path, ignored)) {
    return absl::NotFoundError(absl::StrCat(path, ": there is no such bag"));
  }
  if (!fs::is_directory(path, ignored)) {
    folder.files = {path};
    return folder;
  }
  const std::string metadata = path + "/metadata.yaml";
  if (!fs::exists(metadata, ignored)) return ListFolder(path);
  RETURN_IF_ERROR(UseYamlFields(metadata, [&](const YAML::Node& file) {
    return TakeMetadata(file, path, metadata, folder);
  }));
  return folder;
}

}  // namespace corbslam::client_agent
