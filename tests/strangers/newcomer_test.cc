// A newcomer's mistakes get words that help; where nothing is wrong, nothing is said.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "absl/strings/str_cat.h"
#include "slam/util/testing/case_name.h"
#include "tests/strangers/newcomer_mistakes.h"

namespace corbslam::tests {

using services::ToString;

namespace {

std::vector<NewcomerMistake> All() {
  return NewcomerMistakes(std::string(CORBSLAM_SOURCE_DIR) + "/tests/data/tum_fr1_xyz");
}

class NewcomerTest : public ::testing::TestWithParam<size_t> {};

TEST_P(NewcomerTest, GetsWordsThatHelp) {
  const NewcomerMistake mistake = All()[GetParam()];
  const std::string source = mistake.make(absl::StrCat("newcomer_", GetParam()));
  const Said said = WhatDoctorSays(source);
  EXPECT_EQ(ToString(said.level), ToString(mistake.level)) << mistake.mistake << ": " << said.text;
  EXPECT_THAT(said.text, ::testing::HasSubstr(mistake.says)) << mistake.mistake;
}

INSTANTIATE_TEST_SUITE_P(All, NewcomerTest, ::testing::Range(size_t{0}, All().size()),
                         [](const auto& info) {
                           const NewcomerMistake mistake = All()[info.param];
                           return testing::CaseName(
                               absl::StrCat(mistake.dataset, " ", mistake.mistake));
                         });

}  // namespace
}  // namespace corbslam::tests
