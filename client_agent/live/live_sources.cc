#include "client_agent/live/live_sources.h"

#include <algorithm>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "client_agent/live/push/push_source.h"
#include "client_agent/source/source_kinds.h"
#ifdef CORBSLAM_HAS_GSTREAMER
#include "client_agent/live/gstreamer/gst_source.h"
#endif

namespace corbslam::client_agent {
namespace {

struct KnownSource {
  const char* name;
  const char* usage;
  const char* plays;
  const char* needs;  // What it wants of the build, and of the machine.
};

constexpr KnownSource kSources[] = {
    {"kitti", "kitti:DIR",
     "recordings in KITTI's layouts: stereo, rectified or with a rig; or one camera (cameras=1)",
     ""},
    {"euroc", "euroc:DIR",
     "recordings in EuRoC's (ASL) layout: stereo, rectified while played; or one camera "
     "(cameras=1)",
     ""},
    {"tum", "tum:DIR", "recordings in TUM RGB-D's layout", ""},
    {"7scenes", "7scenes:DIR", "recordings in 7-Scenes' layout: RGB-D", ""},
    {"bag", "bag:BAG",
     "ROS bags: ROS 1's .bag, ROS 2's folders, .db3 and .mcap; a stereo pair or an RGB-D camera",
     ""},
    {"gst", "gst:LEFT || RIGHT",
     "live: whatever GStreamer has an element for (RTSP, MJPEG, devices)",
     "libgstreamer-plugins-base1.0-dev when it is built, gstreamer1.0-plugins-base when it runs"},
    {"v4l2", "v4l2:/dev/video0,/dev/video1", "live: USB and CSI cameras of Linux",
     "the same, and gstreamer1.0-plugins-good"},
    {"aravis", "aravis:NAME, aravis:NAME,NAME, aravis:any",
     "live: GigE Vision and USB3 Vision cameras, by the names that arv-tool-0.8 lists",
     "libgstreamer-plugins-base1.0-dev when it is built, libaravis-0.8-0 when it runs"},
    {"push", "push:SOCKET",
     "live: what a driver program on this machine pushes (docs/push.md, corbslam/push.h)", ""},
    {"ros2", "ros2:topics", "live: what a camera's driver for ROS 2 publishes (docs/ros2.md)",
     "the program corbslam_ros2"},
    {"sim", "sim:WORLD", "a simulator in the camera's place", "the program simulated_agent"}};

// Returns whether this machine has what a kind that the program knows begins with.
bool IsOnThisMachine([[maybe_unused]] absl::string_view kind) {
#ifdef CORBSLAM_HAS_GSTREAMER
  return IsGstSourceHere(kind);
#else
  return true;
#endif
}

}  // namespace

void RegisterLiveSources() {
  RegisterPushSource();
#ifdef CORBSLAM_HAS_GSTREAMER
  RegisterGstSources();
#endif
}

std::string ListSources() {
  std::string text;
  const std::vector<std::string> here = KnownSourceKinds();
  for (const KnownSource& source : kSources) {
    absl::StrAppend(&text, source.usage, ": ", source.plays);
    if (std::find(here.begin(), here.end(), source.name) == here.end()) {
      absl::StrAppend(&text, "; not here, it needs ", source.needs);
    } else if (!IsOnThisMachine(source.name)) {
      absl::StrAppend(&text, "; not on this machine, it needs ", source.needs);
    }
    absl::StrAppend(&text, "\n");
  }
  return text;
}

}  // namespace corbslam::client_agent
