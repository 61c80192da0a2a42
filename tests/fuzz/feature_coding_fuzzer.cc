// Feeds coded features and descriptors alone. What can be read says the same when it is written
// again.
#include <cstdlib>
#include <string_view>
#include <vector>

#include "slam/coding/feature_coding.h"
#include "slam/coding/sourced_descriptors.h"
#include "slam/coding/testing/plausible_features.h"
#include "tests/fuzz/messages.h"

namespace corbslam::tests {
namespace {

constexpr size_t kMaxCount = 20'000;

void ReadFeatures(std::string_view bytes) {
  const auto read = DecodeFeatures(bytes, kMaxCount);
  if (!read.ok()) return;
  if (CountCodedKeypoints(bytes) != read->size()) std::abort();
  const auto again = EncodeFeatures(*read, {640, 480});
  if (!again.has_value()) return;
  const auto once_more = DecodeFeatures(*again, kMaxCount);
  if (!once_more.ok() || !(*once_more == *read)) std::abort();
}

// Reads as many descriptors as the first byte says, some of a keyframe that isn't there.
void ReadDescriptors(std::string_view bytes) {
  static const auto& source =
      *new std::vector<Descriptor>(testing::MakePlausibleFeatures(1, 50, {640, 480}).descriptors);
  if (bytes.empty()) return;
  std::vector<std::span<const Descriptor>> sources(static_cast<uint8_t>(bytes[0]), source);
  for (size_t i = 0; i < sources.size(); i += 3) sources[i] = {};
  const auto read = DecodeSourced(bytes.substr(1), sources);
  if (!read.ok()) return;
  const auto again = DecodeSourced(EncodeSourced(*read, sources), sources);
  if (!again.ok() || *again != *read) std::abort();
}

}  // namespace
}  // namespace corbslam::tests

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace corbslam;         // NOLINT
  using namespace corbslam::tests;  // NOLINT
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  if (input.empty()) return 0;
  if (input[0] == 0) ReadFeatures(input.substr(1));
  if (input[0] == 1) ReadDescriptors(input.substr(1));
  return 0;
}
