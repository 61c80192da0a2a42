// The colours of pictures and plots: the one table of them, which the viewer's page has again in
// page/src/model/palette.ts; a test holds them together. A colour has a name, so that a page that
// shows a drawing gives it the other one where the page is dark.
#ifndef CORBSLAM_SLAM_RENDERING_PAINT_H_
#define CORBSLAM_SLAM_RENDERING_PAINT_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>

namespace corbslam {

struct Paint {
  // Name of the page's CSS variable, without its dashes; null if the colour is the same everywhere.
  const char* variable = nullptr;
  uint8_t red = 0;
  uint8_t green = 0;
  uint8_t blue = 0;
};

// A colour on light and on dark ground, both as 0xrrggbb.
struct NamedPaint : Paint {
  constexpr NamedPaint(const char* name, uint32_t light, uint32_t dark)
      : Paint{name, static_cast<uint8_t>(light >> 16), static_cast<uint8_t>(light >> 8),
              static_cast<uint8_t>(light)},
        on_dark(dark) {}
  uint32_t on_dark;
};

inline constexpr NamedPaint kInk{"ink", 0x1e1e1e, 0xe6e6e6};
inline constexpr NamedPaint kPaper{"paper", 0xffffff, 0x1b1d21};
inline constexpr NamedPaint kMuted{"muted", 0x5c5c5c, 0xa3a8b0};
inline constexpr NamedPaint kGrid{"grid", 0xdedede, 0x3a3e45};
inline constexpr NamedPaint kOwn{"own", 0x0a8f2f, 0x3ddc64};
inline constexpr NamedPaint kOwnEdge{"own-edge", 0x78cd82, 0x2f7a40};
inline constexpr NamedPaint kOthers{"others", 0x1f4fd8, 0x6ea0ff};
inline constexpr NamedPaint kOthersEdge{"others-edge", 0x82afeb, 0x35598f};
inline constexpr NamedPaint kTruth{"truth", 0xc62828, 0xff6b6b};

// Returns the colour of a robot, or of a series that is none, by its number. Eight are told apart
// by those who don't tell red from green, too (after Okabe and Ito); up to 24 are shades of them,
// then they repeat.
const NamedPaint& SeriesPaint(size_t number);

// Numbers robots so that each picture, page and export of any mission gives a robot the same
// colour: a number in the name counts, else its first letter; where two would be the same, the
// later name takes the next one of eight that is free.
std::map<std::string, size_t> NumberRobots(const std::set<std::string>& robots);

// Returns the CSS variables of all named colours: "--ink: #1e1e1e; ...".
std::string PaintVariables(bool on_dark);

// Returns the colour of a value from 0 (blue) over purple to 1 (orange), which can be seen on white
// and on black; of what is no number, grey.
Paint RampPaint(double share);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_RENDERING_PAINT_H_
