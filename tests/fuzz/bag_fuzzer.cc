// Feeds ROS bags: what begins as a bag is one file, what begins with 'M' a message, anything else a
// bag's metadata.yaml.
#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>

#include "absl/strings/match.h"
#include "client_agent/source/bag/bag_contents.h"
#include "client_agent/source/bag/bag_reader.h"
#include "client_agent/source/bag/files/mcap_file.h"
#include "client_agent/source/bag/files/ros1_file.h"
#include "client_agent/source/bag/files/sqlite_file.h"
#include "client_agent/source/bag/messages/ros_messages.h"
#include "client_agent/source/bag/messages/ros_pictures.h"
#include "tests/fuzz/fuzz_files.h"
#include "tests/fuzz/messages.h"

namespace corbslam::tests {

using client_agent::BagEncoding;
using client_agent::BagOptions;
using client_agent::DepthOf;
using client_agent::FormOf;
using client_agent::GreyOf;
using client_agent::OpenBagContents;
using client_agent::ReadBagContents;

namespace {

void Play(const std::string& path) {
  BagOptions options;
  options.path = path;
  options.trust_calibration = true;
  const auto contents = ReadBagContents(path);
  if (!contents.ok()) return;
  for (const client_agent::BagTopic& topic : (*contents)->topics) {
    for (const client_agent::RecordedPlace& place : topic.kept) {
      (void)(*contents)->recording->Read(place);
    }
  }
  const auto reader = OpenBagContents(*contents, options);
  if (!reader.ok()) return;
  for (size_t i = 0; i < std::min<size_t>(2, (*reader)->frame_count()); ++i) {
    (void)(*reader)->timestamp_ns(i);
    (void)(*reader)->Read(i);
  }
}

template <typename Image>
void Decode(const absl::StatusOr<Image>& image) {
  if (!image.ok()) return;
  const client_agent::RosPictureForm form = FormOf(*image);
  // Of a few bytes a decoder would make a large picture, which is slow and shows nothing.
  if (form.size.area() > 1'000'000) return;
  (void)GreyOf(*image);
  (void)DepthOf(*image);
}

void ReadMessage(absl::string_view input) {
  for (const BagEncoding encoding : {BagEncoding::kRos1, BagEncoding::kCdr}) {
    Decode(client_agent::ReadRosImage(encoding, input));
    Decode(client_agent::ReadRosCompressedImage(encoding, input));
    (void)client_agent::ReadRosCameraInfo(encoding, input);
    (void)client_agent::ReadRosTransforms(encoding, input);
  }
}

bool IsBag(absl::string_view input) {
  return absl::StartsWith(input, client_agent::kMcapMagic) ||
         absl::StartsWith(input, client_agent::kRos1Magic) ||
         absl::StartsWith(input, client_agent::kSqliteMagic);
}

}  // namespace
}  // namespace corbslam::tests

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace corbslam::tests;  // NOLINT
  const absl::string_view input = AsText(data, size);
  if (IsBag(input)) {
    Play(WriteFuzzFile("a.bag", input));
  } else if (absl::StartsWith(input, "M")) {
    ReadMessage(input.substr(1));
  } else {
    WriteFuzzFile("folder/metadata.yaml", input);
    WriteFuzzFile("folder/a.mcap", corbslam::client_agent::kMcapMagic);
    Play(FuzzFolder() + "/folder");
  }
  return 0;
}
