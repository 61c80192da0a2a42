// Small recordings to be made strange.
#ifndef CORBSLAM_TESTS_STRANGERS_STRANGE_RECORDINGS_H_
#define CORBSLAM_TESTS_STRANGERS_STRANGE_RECORDINGS_H_

#include <functional>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "client_agent/source/source_spec.h"

namespace corbslam {

// A fresh folder below the test's temporary one.
std::string MakeStrangerFolder(const std::string& name);

// The lines of a file, without their ends, and back.
std::vector<std::string> ReadAllLines(const std::string& path);
void WriteAllLines(const std::string& path, const std::vector<std::string>& lines);
// Every `from` in the file becomes `to`; it must occur.
void ReplaceInFile(const std::string& path, const std::string& from, const std::string& to);

// A copy of the first `frames` of the TUM RGB-D recording at `recording`: associated.txt,
// calibration.yaml with Freiburg 1's values, links to the pictures.
std::string CopyRgbd(const std::string& recording, const std::string& name, size_t frames = 30);

// A drive of 40 m through the simulated town as a recording; drawn once for each layout, then
// copied (pictures as links).
std::string CopyStereo(SourceLayout layout, const std::string& name);

// Reads each file of a folder below `directory`, and puts what `change` makes of it in its place; a
// link is replaced, not followed. `flags` are cv::imread's.
void ChangePictures(const std::string& directory, const std::string& folder, int flags,
                    const std::function<cv::Mat(const cv::Mat&)>& change);

// What `change` makes of each file's bytes takes its place.
void ChangeBytes(const std::string& directory, const std::string& folder,
                 const std::function<std::string(const std::string&)>& change);

// The files of a folder, sorted.
std::vector<std::string> FilesOf(const std::string& folder);

}  // namespace corbslam

#endif  // CORBSLAM_TESTS_STRANGERS_STRANGE_RECORDINGS_H_
