// Makes small recordings that tests then make strange.
#ifndef CORBSLAM_TESTS_STRANGERS_STRANGE_RECORDINGS_H_
#define CORBSLAM_TESTS_STRANGERS_STRANGE_RECORDINGS_H_

#include <functional>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "client_agent/source/source_spec.h"

namespace corbslam::tests {

// Makes a fresh folder below the test's temporary one.
std::string MakeStrangerFolder(const std::string& name);

// Read and write the lines of a file, without their ends.
std::vector<std::string> ReadAllLines(const std::string& path);
void WriteAllLines(const std::string& path, const std::vector<std::string>& lines);
// Every `from` in the file becomes `to`; it must occur.
void ReplaceInFile(const std::string& path, const std::string& from, const std::string& to);

// Copies the first `frames` of the TUM RGB-D recording at `recording`: associated.txt,
// calibration.yaml with Freiburg 1's values, links to the pictures.
std::string CopyRgbd(const std::string& recording, const std::string& name, size_t frames = 30);

// Makes a recording of a drive of 40 m through the simulated town. It is drawn once for each
// layout, then copied (pictures as links).
std::string CopyStereo(client_agent::SourceLayout layout, const std::string& name);

// Reads each file of a folder below `directory`, and puts what `change` makes of it in its place; a
// link is replaced, not followed. `flags` are cv::imread's.
void ChangePictures(const std::string& directory, const std::string& folder, int flags,
                    const std::function<cv::Mat(const cv::Mat&)>& change);

// Puts what `change` makes of each file's bytes in its place.
void ChangeBytes(const std::string& directory, const std::string& folder,
                 const std::function<std::string(const std::string&)>& change);

// Returns the files of a folder, sorted.
std::vector<std::string> FilesOf(const std::string& folder);

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_STRANGERS_STRANGE_RECORDINGS_H_
