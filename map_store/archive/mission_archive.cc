#include "map_store/archive/mission_archive.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/archive/archive.h"
#include "map_store/archive/feature_archive.h"
#include "map_store/archive/formats.h"
#include "map_store/archive/state_archive.h"
#include "map_store/archive/value_fields.h"
#include "slam/util/checksum.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {

namespace {

constexpr std::string_view kMagic = "CORBMISN";
constexpr size_t kHeaderBytes = kMagic.size() + sizeof(kBackupFormat);
constexpr size_t kSectionHeadBytes = 1 + sizeof(uint64_t);
constexpr size_t kChecksumBytes = sizeof(uint32_t);
// A section holds so many bytes of the state.
constexpr size_t kStatePieceBytes = 1 << 20;
// A section's payload has at most so many bytes; a keyframe's features are far smaller.
constexpr uint64_t kMaxPayloadBytes = 64 << 20;

constexpr char kFeatures = 'K';
constexpr char kState = 'S';
constexpr char kEnd = 'E';

uint32_t Checksum(std::string_view bytes) {
  return ExtendCrc32c(0, absl::string_view(bytes.data(), bytes.size()));
}

std::string MakeSection(char kind, std::string_view payload) {
  ArchiveWriter head;
  head(kind, static_cast<uint64_t>(payload.size()));
  std::string section = head.Take();
  section.append(payload);
  ArchiveWriter checksum;
  checksum(Checksum(section));
  return section + checksum.Take();
}

}  // namespace

MissionBackup::MissionBackup(const MissionState& state) : state_(EncodeState(state)) {
  for (const auto& [id, local_map] : state.local_maps) {
    for (const auto& [keyframe_id, keyframe] : local_map.map.keyframes()) {
      keyframes_.push_back(keyframe.payload);
    }
  }
}

std::string MissionBackup::Next(size_t bytes) {
  std::string piece;
  while (piece.size() < bytes) {
    const std::string section = Section();
    if (section.empty()) break;
    piece.append(section);
  }
  return piece;
}

std::string MissionBackup::Section() {
  if (stage_ == Stage::kBegin) {
    stage_ = Stage::kFeatures;
    ArchiveWriter format;
    format(kBackupFormat);
    return std::string(kMagic) + format.Take();
  }
  if (stage_ == Stage::kFeatures) {
    if (next_keyframe_ < keyframes_.size()) {
      // The keyframe is given up once it is written: the mission may have removed it meanwhile.
      const auto keyframe = std::exchange(keyframes_[next_keyframe_++], nullptr);
      ArchiveWriter id;
      id(keyframe->id);
      return MakeSection(kFeatures, absl::StrCat(id.Take(), map_store::EncodeFeatures(*keyframe)));
    }
    stage_ = Stage::kState;
  }
  if (stage_ == Stage::kState) {
    if (next_state_byte_ < state_.size()) {
      const std::string_view rest = std::string_view(state_).substr(next_state_byte_);
      const std::string_view piece = rest.substr(0, kStatePieceBytes);
      next_state_byte_ += piece.size();
      return MakeSection(kState, piece);
    }
    stage_ = Stage::kEnd;
    ArchiveWriter counts;
    counts(static_cast<uint64_t>(keyframes_.size()), static_cast<uint64_t>(state_.size()));
    return MakeSection(kEnd, counts.Take());
  }
  return "";
}

absl::Status MissionRestorer::Damaged(absl::string_view what) const {
  return absl::DataLossError(absl::StrCat("the backup is damaged at byte ", taken_, ": ", what));
}

absl::Status MissionRestorer::Add(std::string_view piece) {
  received_ += piece.size();
  if (received_ > max_bytes_) {
    return absl::ResourceExhaustedError(
        absl::StrCat("the backup has more than ", max_bytes_, " bytes; that is the limit"));
  }
  // Coded features take about half of what they take in memory, and are held until all of them are
  // there.
  if (check_room_ != nullptr) RETURN_IF_ERROR(check_room_(3 * piece.size()));
  pending_.append(piece);
  std::string_view rest = pending_;
  ASSIGN_OR_RETURN(bool took, TakeHeader(rest));
  while (took && !rest.empty()) {
    ASSIGN_OR_RETURN(took, TakeSection(rest));
  }
  pending_.erase(0, pending_.size() - rest.size());
  return absl::OkStatus();
}

absl::StatusOr<bool> MissionRestorer::TakeHeader(std::string_view& rest) {
  if (has_header_) return true;
  const size_t known = std::min(rest.size(), kMagic.size());
  if (rest.substr(0, known) != kMagic.substr(0, known)) {
    return absl::FailedPreconditionError("this is no backup of a mission");
  }
  if (rest.size() < kHeaderBytes) return false;
  uint32_t format = 0;
  std::memcpy(&format, rest.data() + kMagic.size(), sizeof(format));
  if (format < kOldestBackupFormat || format > kBackupFormat) {
    return absl::FailedPreconditionError(absl::StrCat(
        "the backup has format ", format, ", this program reads ", kOldestBackupFormat, " to ",
        kBackupFormat,
        format > kBackupFormat ? ": restore it with the newer program" : kHowToReadOlderBackup));
  }
  rest.remove_prefix(kHeaderBytes);
  taken_ += kHeaderBytes;
  has_header_ = true;
  return true;
}

absl::StatusOr<bool> MissionRestorer::TakeSection(std::string_view& rest) {
  if (is_complete_) return Damaged("more follows its end");
  if (rest.size() < kSectionHeadBytes) return false;
  ArchiveReader head(rest.substr(0, kSectionHeadBytes));
  char kind = 0;
  uint64_t size = 0;
  head(kind, size);
  if (size > kMaxPayloadBytes) return Damaged("a section is too long");
  const size_t checked = kSectionHeadBytes + size;
  if (rest.size() < checked + kChecksumBytes) return false;
  uint32_t checksum = 0;
  std::memcpy(&checksum, rest.data() + checked, sizeof(checksum));
  const std::string_view section = rest.substr(0, checked);
  if (Checksum(section) != checksum) return Damaged("a checksum differs");
  RETURN_IF_ERROR(Take(kind, section.substr(kSectionHeadBytes)));
  rest.remove_prefix(checked + kChecksumBytes);
  taken_ += checked + kChecksumBytes;
  return true;
}

absl::Status MissionRestorer::Take(char kind, std::string_view payload) {
  if (kind == kFeatures) {
    ArchiveReader reader(payload);
    KeyframeId id;
    reader(id);
    ASSIGN_OR_RETURN(Features features,
                     map_store::DecodeFeatures(payload.substr(payload.size() - reader.left())));
    if (!features_.emplace(id, std::move(features)).second) {
      return Damaged(absl::StrCat("keyframe ", ToString(id), " comes twice"));
    }
    return absl::OkStatus();
  }
  if (kind == kState) {
    state_.append(payload);
    return absl::OkStatus();
  }
  if (kind != kEnd) return Damaged("a section of no known kind");
  ArchiveReader reader(payload);
  uint64_t keyframes = 0;
  uint64_t state_bytes = 0;
  reader(keyframes, state_bytes);
  if (!reader.done() || keyframes != features_.size() || state_bytes != state_.size()) {
    return Damaged("sections are missing");
  }
  is_complete_ = true;
  return absl::OkStatus();
}

absl::StatusOr<MissionState> MissionRestorer::Finish() {
  if (!is_complete_) {
    return absl::DataLossError(absl::StrCat("the backup ends too early, after byte ", received_));
  }
  return map_store::DecodeState(state_, [this](KeyframeId id) -> absl::StatusOr<Features> {
    const auto it = features_.find(id);
    if (it == features_.end()) {
      return absl::DataLossError(
          absl::StrCat("the backup lacks the features of keyframe ", ToString(id)));
    }
    return std::move(it->second);
  });
}

}  // namespace corbslam::map_store
