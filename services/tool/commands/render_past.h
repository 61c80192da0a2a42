// Draws a mission's past for `corbslam render`.
#ifndef CORBSLAM_SERVICES_TOOL_COMMANDS_RENDER_PAST_H_
#define CORBSLAM_SERVICES_TOOL_COMMANDS_RENDER_PAST_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "services/client/store/store_reader.h"
#include "services/tool/evaluation/accuracy.h"

namespace corbslam::services {

struct PastOptions {
  std::string at;        // Moments to draw side by side; empty: none.
  std::string animate;   // The file of the animation; empty: none.
  uint32_t moments = 0;  // How many are asked for, 2 to 1,000; 0: as many as suit what is drawn.
  int frames_per_second = 10;
  int width_px = 1200;
};

// Refuses what can't be drawn before anybody is asked. INVALID_ARGUMENT names flag and limits.
absl::Status CheckPastOptions(const PastOptions& options, const std::string& out);

// Draws the moments of --at to `out`, PNG or SVG by its ending, and the animation to its file. Asks
// the store once. UNAVAILABLE names a file that can't be written.
absl::Status RenderPast(StoreReader& store, const std::string& own, const FusedAccuracy& accuracy,
                        const PastOptions& options, const std::string& out);

// Refuses a name that is no picture's, and a width that is none. INVALID_ARGUMENT names flag and
// limits.
absl::Status CheckPictureOptions(const std::string& out, int width_px);
// Returns true for FILE.svg.
bool IsSvg(const std::string& path);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_COMMANDS_RENDER_PAST_H_
