// Finds the vocabulary unless a flag names one.
#ifndef CORBSLAM_SERVICES_PROGRAMS_DEFAULT_VOCABULARY_H_
#define CORBSLAM_SERVICES_PROGRAMS_DEFAULT_VOCABULARY_H_

#include <string>

namespace corbslam::services {

// Returns the path in the environment variable CORBSLAM_VOCABULARY; else
// share/corbslam/corbslam.voc beside the program's bin folder, if there; else the one of the source
// tree that this program was built from.
std::string DefaultVocabularyPath();

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_DEFAULT_VOCABULARY_H_
