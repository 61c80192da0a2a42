// Prints what each of a newcomer's mistakes is told, as a table for docs/strangers.md.
#include <cstdio>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "tests/strangers/newcomer_mistakes.h"

int main() {
  using namespace corbslam;         // NOLINT
  using namespace corbslam::tests;  // NOLINT
  using services::Level;
  std::printf("| layout | what the newcomer did | what is said |\n| --- | --- | --- |\n");
  size_t number = 0;
  for (const NewcomerMistake& mistake :
       NewcomerMistakes(std::string(CORBSLAM_SOURCE_DIR) + "/tests/data/tum_fr1_xyz")) {
    const std::string source = mistake.make(absl::StrCat("newcomer_", number++));
    const size_t begin = source.find(':') + 1;
    const std::string folder = source.substr(begin, source.find('?', begin) - begin);
    const Said said = WhatDoctorSays(source);
    const std::string text = said.level == Level::kOk ? "nothing: it is right" : said.text;
    std::printf("| %s | %s | %s: %s |\n", mistake.dataset.c_str(), mistake.mistake.c_str(),
                ToString(said.level).c_str(),
                absl::StrReplaceAll(text, {{folder, "DIR"}, {"|", "\\|"}}).c_str());
  }
  return 0;
}
