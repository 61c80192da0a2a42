// Feeds the loaders of vocabularies: the binary form, which is mapped into memory, and the text
// form. The first byte says which.
#include <vector>

#include "slam/vocabulary/vocabulary.h"
#include "slam/vocabulary/vocabulary_file.h"
#include "tests/fuzz/fuzz_files.h"
#include "tests/fuzz/messages.h"

namespace corbslam::tests {
namespace {

// Uses the vocabulary, whose content must not make any look-up leave the file.
void Use(const Vocabulary& vocabulary) {
  std::vector<Descriptor> descriptors(8);
  for (size_t i = 0; i < descriptors.size(); ++i) {
    descriptors[i].words = {i * 0x9e3779b97f4a7c15, ~i, i << 40, 0};
  }
  (void)vocabulary.Transform(descriptors);
  vocabulary.Verify().IgnoreError();
}

}  // namespace
}  // namespace corbslam::tests

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace corbslam;         // NOLINT
  using namespace corbslam::tests;  // NOLINT
  if (size == 0) return 0;
  const std::string path = WriteFuzzFile("vocabulary", AsText(data + 1, size - 1));
  if (data[0] % 2 == 0) {
    if (const auto vocabulary = Vocabulary::Load(path); vocabulary.ok()) Use(**vocabulary);
    (void)InspectVocabulary(path);
    return 0;
  }
  auto tree = ReadTextVocabulary(path);
  if (!tree.ok()) return 0;
  if (const auto vocabulary = Vocabulary::FromTree(*std::move(tree)); vocabulary.ok()) {
    Use(**vocabulary);
  }
  return 0;
}
