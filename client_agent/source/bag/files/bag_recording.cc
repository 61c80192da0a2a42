#include "client_agent/source/bag/files/bag_recording.h"

#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client_agent/source/bag/files/bag_folder.h"
#include "client_agent/source/bag/files/unpack.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {

absl::StatusOr<std::unique_ptr<BagRecording>> BagRecording::Open(const std::string& path) {
  ASSIGN_OR_RETURN(BagFolder folder, FindBagFiles(path));
  auto recording = std::make_unique<BagRecording>();
  recording->path_ = path;
  recording->message_compression_ = std::move(folder.message_compression);
  recording->notes_ = std::move(folder.notes);
  absl::Status first_error;
  for (const std::string& name : folder.files) {
    absl::StatusOr<std::unique_ptr<BagFile>> file = OpenBagFile(name);
    if (file.ok()) {
      recording->files_.push_back(*std::move(file));
      continue;
    }
    if (first_error.ok()) first_error = file.status();
    recording->notes_.push_back(absl::StrCat(file.status().message(), ": left out"));
  }
  if (recording->files_.empty()) return first_error;
  return recording;
}

size_t BagRecording::NumberOf(const BagChannel& channel) {
  const auto [known, is_new] = numbers_.emplace(channel, channels_.size());
  if (is_new) channels_.push_back(channel);
  return known->second;
}

void BagRecording::Scan(Use use) {
  for (uint32_t number = 0; number < files_.size(); ++number) {
    BagFile& file = *files_[number];
    std::vector<size_t> channels;  // By the file's own.
    const auto take = [&](const ScannedMessage& message) {
      for (size_t i = channels.size(); i < file.channels().size(); ++i) {
        channels.push_back(NumberOf(file.channels()[i]));
      }
      ScannedMessage known = message;
      known.channel = channels[message.channel];
      if (message_compression_.empty()) return use(known, number);
      const absl::StatusOr<std::string> whole = Read({number, message.place});
      if (!whole.ok()) return;
      known.head = absl::string_view(*whole).substr(0, kBagHeadBytes);
      use(known, number);
    };
    file.Scan(take);
    for (const BagChannel& channel : file.channels()) NumberOf(channel);
  }
}

std::string BagRecording::format() const {
  std::string format(files_.front()->format());
  if (!message_compression_.empty()) {
    absl::StrAppend(&format, ", messages packed by ", message_compression_);
  }
  return format;
}

std::vector<std::string> BagRecording::notes() const {
  std::vector<std::string> notes = notes_;
  for (const std::unique_ptr<BagFile>& file : files_) {
    notes.insert(notes.end(), file->notes().begin(), file->notes().end());
  }
  return notes;
}

absl::StatusOr<std::string> BagRecording::Read(const RecordedPlace& place) const {
  const BagFile& file = *files_[place.file];
  ASSIGN_OR_RETURN(std::string bytes, file.Read(place.place));
  if (message_compression_.empty()) return bytes;
  absl::StatusOr<std::string> unpacked = Unpack(message_compression_, bytes, std::nullopt);
  if (unpacked.ok()) return unpacked;
  return absl::InvalidArgumentError(absl::StrCat(path_, ": a message at ", place.place.offset, ": ",
                                                 unpacked.status().message()));
}

}  // namespace corbslam::client_agent
