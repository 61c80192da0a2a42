// Where the vocabulary is unless a flag says otherwise.
#ifndef CORBSLAM_SERVICES_PROGRAMS_DEFAULT_VOCABULARY_H_
#define CORBSLAM_SERVICES_PROGRAMS_DEFAULT_VOCABULARY_H_

#include <string>

namespace corbslam {

// The environment variable CORBSLAM_VOCABULARY; else share/corbslam/corbslam.voc beside the
// program's bin folder, if there; else the one of the source tree that this was built from.
std::string DefaultVocabularyPath();

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_PROGRAMS_DEFAULT_VOCABULARY_H_
