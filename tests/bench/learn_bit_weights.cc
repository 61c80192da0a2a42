// Learns how likely a descriptor's bits are, given those before them, from pictures and prints
// learned_bit_weights.cc.
//
//   learn_bit_weights FOLDER_OF_PICTURES > slam/coding/learned_bit_weights.cc
//
// Each bit's logistic regression on the bits before it (descriptor_model.h), all 256 at once, by
// stochastic gradient descent with momentum on the features of all pictures. The descent is on
// inputs that are decorrelated first, by the Cholesky factor of their covariance: being lower
// triangular, it mixes into each only those before it. Necessary whenever the binary tests change
// (slam/features/learned_brief_pattern.cc).
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <string>
#include <vector>

#include "slam/coding/descriptor_model.h"
#include "slam/features/orb_extractor.h"

namespace corbslam {
namespace {

constexpr int kBits = kDescriptorBits;
constexpr int kFeatures = 2000;
constexpr int kTogether = 512;
constexpr int kPasses = 4;
constexpr double kFirstRate = 0.1;
constexpr float kMomentum = 0.9f;

using Matrix = Eigen::MatrixXf;

std::vector<Descriptor> DescribePictures(const std::string& folder) {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  OrbExtractor extractor(OrbOptions{.features = kFeatures});
  std::vector<Descriptor> all;
  for (const std::filesystem::path& path : paths) {
    Features features;
    ImagePyramid pyramid;
    const cv::Mat picture = cv::imread(path, cv::IMREAD_GRAYSCALE);
    if (picture.empty() || !extractor.Extract(picture, features, pyramid).ok()) continue;
    all.insert(all.end(), features.descriptors.begin(), features.descriptors.end());
  }
  return all;
}

// Shuffles by a fixed seed, since std::shuffle is not the same on every platform.
void Shuffle(std::vector<Descriptor>& descriptors) {
  std::mt19937 random(1);
  for (size_t i = descriptors.size(); i > 1; --i) {
    std::swap(descriptors[i - 1], descriptors[random() % i]);
  }
}

// Writes one column a descriptor: its bits as +1 and -1.
void FillBits(const Descriptor* descriptors, Matrix& bits) {
  bits.resize(kBits, kTogether);
  for (int i = 0; i < kTogether; ++i) {
    for (int k = 0; k < kBits; ++k) {
      const uint64_t word = descriptors[i].words[static_cast<size_t>(k) / 64];
      bits(k, i) = (word >> (k % 64) & 1) != 0 ? 1 : -1;
    }
  }
}

// Log-odds of the bits are weights * bits + bias.
struct Regression {
  Matrix weights;
  Eigen::VectorXf bias;
};

// Turns bits into ones of no mean and unit covariance.
struct Decorrelation {
  Eigen::VectorXf mean;
  Matrix factor;  // Lower triangular: bits = factor * decorrelated + mean.

  void Apply(Matrix& bits) const {
    bits.colwise() -= mean;
    factor.triangularView<Eigen::Lower>().solveInPlace(bits);
  }
};

Decorrelation Decorrelate(const std::vector<Descriptor>& descriptors) {
  Decorrelation made{Eigen::VectorXf::Zero(kBits), Matrix::Zero(kBits, kBits)};
  Matrix bits;
  const size_t steps = descriptors.size() / kTogether;
  for (size_t step = 0; step < steps; ++step) {
    FillBits(&descriptors[step * kTogether], bits);
    made.mean += bits.rowwise().mean() / static_cast<float>(steps);
    made.factor.noalias() += bits * bits.transpose() / static_cast<float>(steps * kTogether);
  }
  made.factor -= made.mean * made.mean.transpose();
  made.factor = Matrix(made.factor.llt().matrixL());
  return made;
}

// Turns log-odds into what the gradient of the code's length is against; returns that length, in
// bits.
double ComputeErrors(const Matrix& bits, Matrix& log_odds) {
  double length = 0;
  for (Eigen::Index i = 0; i < bits.cols(); ++i) {
    for (Eigen::Index k = 0; k < bits.rows(); ++k) {
      const float unlikely = std::exp(-bits(k, i) * log_odds(k, i));
      length += std::log2(1 + unlikely);
      log_odds(k, i) = bits(k, i) * unlikely / (1 + unlikely);
    }
  }
  return length;
}

Regression Learn(const std::vector<Descriptor>& descriptors) {
  const Decorrelation decorrelation = Decorrelate(descriptors);
  Regression learned{Matrix::Zero(kBits, kBits), Eigen::VectorXf::Zero(kBits)};
  Regression speed = learned;
  Matrix bits;
  const size_t steps = descriptors.size() / kTogether;
  for (int pass = 0; pass < kPasses; ++pass) {
    double length = 0;
    for (size_t step = 0; step < steps; ++step) {
      FillBits(&descriptors[step * kTogether], bits);
      Matrix inputs = bits;
      decorrelation.Apply(inputs);
      Matrix errors = (learned.weights * inputs).colwise() + learned.bias;
      length += ComputeErrors(bits, errors);
      Matrix gradient = errors * inputs.transpose() / kTogether;
      // Only bits before it say anything of a bit.
      gradient.triangularView<Eigen::Upper>().setZero();
      const double done = (pass + static_cast<double>(step) / static_cast<double>(steps)) / kPasses;
      const auto rate = static_cast<float>(kFirstRate * (1 - done));
      speed.weights = kMomentum * speed.weights + gradient;
      speed.bias = kMomentum * speed.bias + errors.rowwise().mean();
      learned.weights += rate * speed.weights;
      learned.bias += rate * speed.bias;
    }
    std::cerr << "pass " << pass + 1 << ": " << length / static_cast<double>(steps * kTogether)
              << " bits a descriptor\n";
  }
  // The weights were learned for decorrelated inputs; these are the weights for the bits
  // themselves.
  const Matrix transposed = decorrelation.factor.transpose().triangularView<Eigen::Upper>().solve(
      Matrix(learned.weights.transpose()));
  learned.weights = transposed.transpose();
  learned.bias -= learned.weights * decorrelation.mean;
  return learned;
}

class Printer {
 public:
  void Print(float weight) {
    const float steps = std::round(weight * kLogOddsSteps);
    if (std::abs(steps) > 127) ++clipped_;
    const std::string text = std::to_string(static_cast<int>(std::clamp(steps, -127.f, 127.f)));
    if (line_.size() + text.size() + 1 > 100) Break();
    line_ += text + ",";
  }
  void Break() {
    if (!line_.empty()) std::cout << line_ << "\n";
    line_.clear();
  }
  int clipped() const { return clipped_; }

 private:
  std::string line_;
  int clipped_ = 0;
};

void PrintSource(const Regression& learned, size_t descriptors) {
  Printer printer;
  std::cout << "// Written by learn_bit_weights: " << descriptors
            << " descriptors. Do not edit.\n"
               "#include \"slam/coding/descriptor_model.h\"\n\n"
               "namespace corbslam {\n\n"
               "// clang-format off\n"
               "const std::array<int8_t, kDescriptorBits> kLearnedBitBias = {\n";
  for (int k = 0; k < kBits; ++k) printer.Print(learned.bias(k));
  printer.Break();
  std::cout << "};\n\nconst std::array<int8_t, kLearnedWeights> kLearnedBitWeights = {\n";
  for (int j = 0; j < kBits; ++j) {
    for (int k = j + 1; k < kBits; ++k) printer.Print(learned.weights(k, j));
  }
  printer.Break();
  std::cout << "};\n// clang-format on\n\n}  // namespace corbslam\n";
  std::cerr << printer.clipped() << " weights were larger than fits\n";
}

}  // namespace
}  // namespace corbslam

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: learn_bit_weights FOLDER_OF_PICTURES\n";
    return 1;
  }
  std::vector<corbslam::Descriptor> descriptors = corbslam::DescribePictures(argv[1]);
  if (descriptors.size() < corbslam::kTogether) {
    std::cerr << argv[1] << " has " << descriptors.size() << " features, too few to learn from\n";
    return 1;
  }
  corbslam::Shuffle(descriptors);
  corbslam::PrintSource(corbslam::Learn(descriptors), descriptors.size());
  return 0;
}
