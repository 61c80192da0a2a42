// The colours of pictures and plots. A colour has a name, so that a page that shows a drawing can
// give it another one where the page is dark.
#ifndef CORBSLAM_SLAM_RENDERING_PAINT_H_
#define CORBSLAM_SLAM_RENDERING_PAINT_H_

#include <array>
#include <cstddef>
#include <cstdint>

namespace corbslam {

struct Paint {
  // Name of the page's CSS variable, without its dashes; null if the colour is the same everywhere.
  const char* variable = nullptr;
  uint8_t red = 0;
  uint8_t green = 0;
  uint8_t blue = 0;
};

inline constexpr Paint kInk{"ink", 30, 30, 30};
inline constexpr Paint kPaper{"paper", 255, 255, 255};
inline constexpr Paint kMuted{"muted", 105, 105, 105};
inline constexpr Paint kGrid{"grid", 222, 222, 222};
inline constexpr Paint kOwn{"own", 40, 160, 60};
inline constexpr Paint kOwnEdge{"own-edge", 120, 205, 130};
inline constexpr Paint kOthers{"others", 20, 90, 210};
inline constexpr Paint kOthersEdge{"others-edge", 130, 175, 235};
inline constexpr Paint kTruth{"truth", 215, 40, 40};

// The colours of robots in plots: the first is that of own keyframes, the second that of others'.
inline constexpr std::array<Paint, 8> kSeriesPaints = {{{"series-1", 30, 140, 50},
                                                        {"series-2", 20, 90, 210},
                                                        {"series-3", 205, 95, 10},
                                                        {"series-4", 130, 60, 200},
                                                        {"series-5", 0, 130, 130},
                                                        {"series-6", 195, 30, 110},
                                                        {"series-7", 125, 85, 45},
                                                        {"series-8", 110, 120, 0}}};
// Returns the colour of the `index`th robot; they repeat.
constexpr Paint SeriesPaint(size_t index) { return kSeriesPaints[index % kSeriesPaints.size()]; }

// Returns the colour of a value from 0 (blue) over purple to 1 (orange), which can be seen on white
// and on black; of what is no number, grey.
Paint RampPaint(double share);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_RENDERING_PAINT_H_
