// What every sensor yields: keypoints with optional depth, and their binary descriptors.
#ifndef CORBSLAM_SLAM_FEATURES_KEYPOINT_H_
#define CORBSLAM_SLAM_FEATURES_KEYPOINT_H_

#include <Eigen/Core>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#if defined(__ARM_NEON)
#include <arm_neon.h>
#endif

namespace corbslam {

// A keypoint in undistorted pixels of the (left) camera.
struct Keypoint {
  float x_px = 0;
  float y_px = 0;
  // x_left - x_right of a rectified pair, or fx * baseline / depth for RGB-D; it is unknown if 0 or
  // less.
  float disparity_px = 0;
  // Orientation of the patch (intensity centroid), radians, (-pi, pi].
  float angle_rad = 0;
  // Pyramid level, 0 the finest.
  uint8_t octave = 0;

  bool HasDepth() const { return disparity_px > 0; }
  Eigen::Vector2d Pixel() const { return {x_px, y_px}; }
  friend bool operator==(const Keypoint&, const Keypoint&) = default;
};

// 256 bits of steered BRIEF (ORB, Rublee et al., ICCV 2011).
struct Descriptor {
  std::array<uint64_t, 4> words = {};
  friend auto operator<=>(const Descriptor&, const Descriptor&) = default;
};
static_assert(sizeof(Descriptor) == 32);

// Returns the number of differing bits, 0 to 256.
inline int HammingDistance(const Descriptor& a, const Descriptor& b) {
#if defined(__ARM_NEON) && defined(__aarch64__)
  // Of general registers arm64 counts no bits: words would travel to vectors one by one.
  const auto differing = [&](size_t word) {
    const uint64x2_t bits =
        veorq_u64(vld1q_u64(a.words.data() + word), vld1q_u64(b.words.data() + word));
    return vcntq_u8(vreinterpretq_u8_u64(bits));
  };
  // Each byte of the sum is at most 16, and all of them 256.
  return vaddlvq_u8(vaddq_u8(differing(0), differing(2)));
#else
  return std::popcount(a.words[0] ^ b.words[0]) + std::popcount(a.words[1] ^ b.words[1]) +
         std::popcount(a.words[2] ^ b.words[2]) + std::popcount(a.words[3] ^ b.words[3]);
#endif
}

// The arrays are parallel: descriptors[i] belongs to keypoints[i].
struct Features {
  std::vector<Keypoint> keypoints;
  std::vector<Descriptor> descriptors;
};

// The scale pyramid that octaves refer to. The whole system has one: the descriptors of two robots
// match only when they share it.
struct ScalePyramid {
  static constexpr int kLevels = 8;
  static constexpr double kFactor = 1.2;

  // Returns kFactor^octave.
  static double Scale(int octave);
  // Variance of a keypoint's position, px^2: Scale^2 (one pixel of its own level).
  static double Variance_px2(int octave);
  // Returns the level at which a point first seen so that its largest distance is `max_distance`
  // appears from `distance`; clamped to the pyramid (ORB-SLAM, Mur-Artal et al., T-RO 2015, III.C).
  static int PredictOctave(double max_distance, double distance);
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_FEATURES_KEYPOINT_H_
