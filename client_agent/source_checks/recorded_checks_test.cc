// Runs the checks on recorded sequences, as they are and damaged.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "client_agent/source_checks/source_checks.h"
#include "client_agent/source_checks/testing/damage_name.h"
#include "client_agent/source_checks/testing/sample_source.h"

namespace corbslam::client_agent {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

struct Recorded {
  const char* spec;  // $REPO: what ships with the project; $DATA: where the others are.
  const char* damage;
  double amount;
  const char* code;  // "": none.
};

class RecordedChecksTest : public ::testing::TestWithParam<Recorded> {};

TEST_P(RecordedChecksTest, FindTheDamageAndNothingElse) {
  const char* data = std::getenv("CORBSLAM_DATA_DIR");
  std::string spec = absl::StrReplaceAll(
      GetParam().spec, {{"$REPO", absl::StrCat(CORBSLAM_SOURCE_DIR, "/tests/data")}});
  if (spec.find("$DATA") != std::string::npos) {
    if (data == nullptr && std::getenv("CI") == nullptr) GTEST_SKIP() << "no CORBSLAM_DATA_DIR";
    ASSERT_NE(data, nullptr) << "CI runs need CORBSLAM_DATA_DIR";
    spec = absl::StrReplaceAll(spec, {{"$DATA", data}});
  }
  const auto source = OpenSampleSource(spec);
  ASSERT_TRUE(source.ok()) << source.status();
  const auto sample = TakeSample(*source, GetParam().damage, GetParam().amount);
  ASSERT_TRUE(sample.ok()) << sample.status();
  const SourceFindings findings = JudgeSample(source->calibration, *sample).findings;
  if (*GetParam().code == '\0') {
    EXPECT_THAT(CodesOf(findings), IsEmpty()) << findings[0].text;
  } else {
    EXPECT_THAT(CodesOf(findings), ElementsAre(GetParam().code));
  }
}

constexpr char kTum[] = "tum:$REPO/tum_fr1_xyz?camera=freiburg1";
constexpr char kKitti[] = "kitti:$DATA/kitti_00_first201";
constexpr char kEuroc[] = "euroc:$DATA/euroc_v1_01_first40";

INSTANTIATE_TEST_SUITE_P(
    Tum, RecordedChecksTest,
    ::testing::Values(Recorded{kTum, "", 0, ""}, Recorded{kTum, "noise", 12, ""},
                      Recorded{kTum, "dark", 3, ""}, Recorded{kTum, "depth_shift", 4, ""},
                      Recorded{kTum, "dark", 32, "warning pictures-nearly-black"},
                      Recorded{kTum, "bright", 6, "warning pictures-overexposed"},
                      Recorded{kTum, "depth_late", 1, "warning depth-late"},
                      Recorded{kTum, "depth_late", 2, "warning depth-late"},
                      Recorded{kTum, "depth_shift", -12, "warning depth-not-registered"},
                      Recorded{kTum, "depth_saturated", 0, "warning depth-saturated"},
                      Recorded{kTum, "depth_scale", 0.2, "warning depth-units-implausible"},
                      Recorded{kTum, "depth_empty", 0, "error depth-empty"}),
    DamageName<Recorded>);
INSTANTIATE_TEST_SUITE_P(Kitti, RecordedChecksTest,
                         ::testing::Values(Recorded{kKitti, "", 0, ""},
                                           Recorded{kKitti, "noise", 12, ""},
                                           Recorded{kKitti, "exchanged", 0, "error pair-exchanged"},
                                           Recorded{kKitti, "same", 0, "error pair-same-picture"},
                                           Recorded{kKitti, "rows", 2, "warning pair-rows-apart"},
                                           Recorded{kKitti, "rows", 8, "error pair-rows-apart"},
                                           Recorded{kKitti, "roll", 1, "error pair-rows-apart"},
                                           Recorded{kKitti, "late", 1, "warning pair-late"},
                                           Recorded{kKitti, "late", 2, "warning pair-late"},
                                           Recorded{kKitti, "mirrored", 0, "error pair-unrelated"}),
                         DamageName<Recorded>);
INSTANTIATE_TEST_SUITE_P(Euroc, RecordedChecksTest,
                         ::testing::Values(Recorded{kEuroc, "", 0, ""},
                                           Recorded{kEuroc, "noise", 12, ""},
                                           Recorded{kEuroc, "exchanged", 0, "error pair-exchanged"},
                                           Recorded{kEuroc, "rows", 2, "warning pair-rows-apart"},
                                           Recorded{kEuroc, "mirrored", 0, "error pair-unrelated"}),
                         DamageName<Recorded>);

}  // namespace
}  // namespace corbslam::client_agent
