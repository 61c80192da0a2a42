// Feeds rig files and the calibrations that become some. The first byte says which: a rig file, or
// one or two files of a calibration tool.
#include <cstdlib>
#include <string>
#include <variant>

#include "client_agent/source/rig/convert/rig_convert.h"
#include "client_agent/source/rig/rig_file.h"
#include "slam/sensor/sensor.h"
#include "tests/fuzz/fuzz_files.h"
#include "tests/fuzz/messages.h"

namespace corbslam::tests {

using client_agent::CalibrationOf;
using client_agent::ConvertRig;
using client_agent::FormatRig;
using client_agent::JudgeRig;
using client_agent::ReadRigFile;
using client_agent::Rig;
using client_agent::RigFiles;

namespace {

// Larger pictures cost the fuzzer its time.
constexpr int kMaxPixels = 20000;

bool IsSmall(const Rig& rig) {
  for (const auto& camera : rig.cameras) {
    if (camera.width_px > kMaxPixels / camera.height_px) return false;
  }
  return true;
}

// What was read must be writable, and come back; what a robot makes of it must not be nonsense.
void Use(Rig rig) {
  rig.mask_file.clear();
  (void)JudgeRig(rig, "rig", false);
  const std::string again = WriteFuzzFile("again.yaml", FormatRig(rig, "the fuzzer"));
  const auto read = ReadRigFile(again);
  if (!read.ok() || read->cameras.size() != rig.cameras.size()) std::abort();
  for (size_t i = 0; i < rig.cameras.size(); ++i) {
    if (!(read->cameras[i].raw == rig.cameras[i].raw)) std::abort();
  }
  if (!IsSmall(rig)) return;
  const auto calibration = CalibrationOf(rig);
  if (!calibration.ok()) return;
  const auto sensor = MakeSensor(*calibration, SensorOptions{.parallel = false});
  if (sensor.ok() && !Validate((*sensor)->camera()).ok()) std::abort();
}

void ReadRig(absl::string_view input) {
  const auto rig = ReadRigFile(WriteFuzzFile("rig.yaml", input));
  if (rig.ok()) Use(*rig);
}

void Convert(absl::string_view input, bool two) {
  RigFiles files;
  files.size.emplace();
  files.size->width_px = 64;
  files.size->height_px = 48;
  files.paths.push_back(WriteFuzzFile("left.yaml", two ? TakeMessage(input) : input));
  if (two) files.paths.push_back(WriteFuzzFile("right.yaml", input));
  const auto converted = ConvertRig(files);
  if (converted.ok()) Use(converted->rig);
}

}  // namespace
}  // namespace corbslam::tests

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace corbslam;         // NOLINT
  using namespace corbslam::tests;  // NOLINT
  const absl::string_view input = AsText(data, size);
  if (input.empty()) return 0;
  switch (static_cast<uint8_t>(input[0]) % 3) {
    case 0:
      ReadRig(input.substr(1));
      break;
    case 1:
      Convert(input.substr(1), false);
      break;
    default:
      Convert(input.substr(1), true);
  }
  return 0;
}
