// Names cases of tests that damage what a source gives.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_TESTING_DAMAGE_NAME_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_TESTING_DAMAGE_NAME_H_

#include <gtest/gtest.h>

#include <string>

#include "absl/strings/str_cat.h"
#include "slam/util/testing/case_name.h"

namespace corbslam::client_agent {

// Names cases by what is damaged, and how much: "dark_32".
template <typename Case>
std::string DamageName(const ::testing::TestParamInfo<Case>& info) {
  const std::string damage = info.param.damage;
  return testing::CaseName(damage.empty() ? "undamaged"
                                          : absl::StrCat(damage, "_", info.param.amount));
}

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_TESTING_DAMAGE_NAME_H_
