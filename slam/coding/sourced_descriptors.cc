#include "slam/coding/sourced_descriptors.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "slam/coding/adaptive_models.h"
#include "slam/coding/byte_fields.h"
#include "slam/coding/descriptor_streams.h"
#include "slam/coding/stream_fields.h"

namespace corbslam {
namespace {

// The format is: version, stream of choices, streams of the descriptors that are no copies,
// checksum.
constexpr size_t kStreams = 1 + kDescriptorStreams;

// Codes which of its source's descriptors each is a copy of. Points are made in the order of the
// keypoints, so that a copy's index is mostly a little above the last one's.
class ChoiceModel {
 public:
  // Writes `choice`, or reads it; none: no copy. Returns false when there is no such descriptor.
  template <typename Coder>
  bool Code(Coder& coder, size_t source_size, std::optional<size_t>& choice) {
    if (source_size == 0) return true;
    if (!is_copy_.Code(coder, choice.has_value())) {
      choice.reset();
      return true;
    }
    const auto wanted = static_cast<int64_t>(choice.value_or(0));
    const int64_t chosen = last_ + step_.Code(coder, static_cast<int32_t>(wanted - last_));
    if (chosen < 0 || chosen >= static_cast<int64_t>(source_size)) return false;
    choice = static_cast<size_t>(chosen);
    last_ = chosen;
    return true;
  }
  size_t last() const { return static_cast<size_t>(last_); }

 private:
  AdaptiveBit is_copy_;
  DifferenceModel step_;
  int64_t last_ = 0;
};

// Looks for an equal descriptor from `begin` on to the end, then before it.
std::optional<size_t> Find(const Descriptor& descriptor, std::span<const Descriptor> source,
                           size_t begin) {
  const auto middle = source.begin() + static_cast<std::ptrdiff_t>(std::min(begin, source.size()));
  auto found = std::find(middle, source.end(), descriptor);
  if (found == source.end()) {
    found = std::find(source.begin(), middle, descriptor);
    if (found == middle) return std::nullopt;
  }
  return static_cast<size_t>(found - source.begin());
}

absl::Status Malformed(absl::string_view what) {
  return absl::InvalidArgumentError(absl::StrCat("coded descriptors: ", what));
}

}  // namespace

std::string EncodeSourced(std::span<const Descriptor> descriptors, DescriptorSources sources) {
  BitWriter writer;
  ChoiceModel model;
  std::vector<Descriptor> others;
  for (size_t i = 0; i < descriptors.size(); ++i) {
    std::optional<size_t> choice = Find(descriptors[i], sources[i], model.last());
    if (!choice.has_value()) others.push_back(descriptors[i]);
    model.Code(writer, sources[i].size(), choice);
  }
  std::vector<std::string> streams = {writer.Finish()};
  std::ranges::move(EncodeDescriptors(others), std::back_inserter(streams));
  std::string bytes(1, static_cast<char>(kSourcedDescriptorsVersion));
  AppendStreams(streams, &bytes);
  AppendChecksum(ExtendCrc32cBy(0, std::vector<Descriptor>(descriptors.begin(), descriptors.end())),
                 &bytes);
  return bytes;
}

absl::StatusOr<std::vector<Descriptor>> DecodeSourced(std::string_view bytes,
                                                      DescriptorSources sources) {
  FieldReader fields(bytes);
  const std::string_view version = fields.Piece(1);
  if (version.empty()) return Malformed("cut short, 0 bytes");
  if (static_cast<uint8_t>(version[0]) != kSourcedDescriptorsVersion) {
    return Malformed(absl::StrCat("version is ", static_cast<uint8_t>(version[0]),
                                  ", this program reads ", kSourcedDescriptorsVersion));
  }
  const auto streams = TakeStreams<kStreams>(fields);
  if (!streams.has_value()) return Malformed("cut short, or a stream is longer than all there is");
  BitReader reader((*streams)[0]);
  ChoiceModel model;
  std::vector<Descriptor> descriptors(sources.size());
  std::vector<size_t> others;
  for (size_t i = 0; i < sources.size(); ++i) {
    std::optional<size_t> choice;
    if (!model.Code(reader, sources[i].size(), choice)) {
      return Malformed(absl::StrCat("descriptor ", i, " is a copy of none of the ",
                                    sources[i].size(), " of its keyframe"));
    }
    if (choice.has_value()) {
      descriptors[i] = sources[i][*choice];
    } else {
      others.push_back(i);
    }
  }
  std::array<std::string_view, kDescriptorStreams> of_others;
  std::copy(streams->begin() + 1, streams->end(), of_others.begin());
  std::vector<Descriptor> read(others.size());
  if (!reader.done() || !DecodeDescriptors(of_others, read)) {
    return Malformed(absl::StrCat("the streams are not those of ", sources.size()));
  }
  for (size_t i = 0; i < others.size(); ++i) descriptors[others[i]] = read[i];
  if (!EndsWithChecksum(fields, ExtendCrc32cBy(0, descriptors))) {
    return Malformed("the checksum differs, or more follows it");
  }
  return descriptors;
}

}  // namespace corbslam
