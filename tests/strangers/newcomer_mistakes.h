// The ten most probable mistakes of a newcomer with each public layout, and the words they get.
#ifndef CORBSLAM_TESTS_STRANGERS_NEWCOMER_MISTAKES_H_
#define CORBSLAM_TESTS_STRANGERS_NEWCOMER_MISTAKES_H_

#include <functional>
#include <string>
#include <vector>

#include "services/security/finding.h"

namespace corbslam::tests {

struct NewcomerMistake {
  std::string dataset;
  std::string mistake;  // The mistake in words.
  // Makes the recording in a folder of this name, and returns what the newcomer calls it.
  std::function<std::string(const std::string&)> make;
  services::Level level =
      services::Level::kFail;  // Worst level that corbslam doctor --source says.
  std::string says;            // A part of the text of that finding.
};

// `recording` is the TUM RGB-D recording in tests/data.
std::vector<NewcomerMistake> NewcomerMistakes(const std::string& recording);

// The worst finding's level and text.
struct Said {
  services::Level level = services::Level::kOk;
  std::string text;
};
Said WhatDoctorSays(const std::string& source);

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_STRANGERS_NEWCOMER_MISTAKES_H_
