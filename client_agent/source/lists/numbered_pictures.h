// Lists folders of pictures that are named by their number: 000000.png, 000001.png, ...
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_NUMBERED_PICTURES_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_NUMBERED_PICTURES_H_

#include <cstddef>
#include <map>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace corbslam::client_agent {

// Returns number -> path of the files of `folder` whose names are `prefix`, digits, and `suffix`
// with one of the endings .png, .jpg, .jpeg, .bmp, .pgm, .ppm, .tif, .tiff; others are passed over.
// Returns NOT_FOUND where there is no such folder; INVALID_ARGUMENT, naming the files, where a
// number is there twice or has more than seven digits.
absl::StatusOr<std::map<size_t, std::string>> ListNumberedPictures(const std::string& folder,
                                                                   absl::string_view prefix,
                                                                   absl::string_view suffix);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_NUMBERED_PICTURES_H_
