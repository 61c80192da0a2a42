// Text and numbers as SVG and HTML take them.
#ifndef CORBSLAM_SLAM_RENDERING_SVG_TEXT_H_
#define CORBSLAM_SLAM_RENDERING_SVG_TEXT_H_

#include <cstddef>
#include <string>

#include "absl/strings/string_view.h"

namespace corbslam {

// Returns the text so that it stands in an element or in a quoted attribute, whatever it is: names
// come from robots and from files. Bytes that are no UTF-8, and characters that XML forbids, become
// U+FFFD.
std::string EscapeMarkup(absl::string_view text);

// Returns the text, shortened to at most `most` characters of UTF-8, the last of them an ellipsis.
std::string Shorten(absl::string_view text, size_t most);

// Counts characters of UTF-8.
size_t CountCharacters(absl::string_view text);

// Returns the number with at most `decimals` (0 to 6) of them, without zeros at the end. What is
// not finite is 0.
std::string FormatShort(double number, int decimals);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_RENDERING_SVG_TEXT_H_
