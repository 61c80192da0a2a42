#include "tests/accuracy/said_cameras.h"

#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "slam/geometry/lie.h"

namespace corbslam::tests {
namespace {

using Random = std::mt19937_64;
using Change = std::function<void(Random&, SaidPicture&)>;

double Between(double low, double high, Random& random) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

// Returns a factor whose logarithm is uniform, or its inverse.
double Factor(double least, double most, Random& random) {
  const double factor = std::exp(Between(std::log(least), std::log(most), random));
  return random() % 2 == 0 ? factor : 1 / factor;
}

void ScaleFocal(double x, double y, SaidPicture& said) {
  said.camera.fx_px *= x;
  said.camera.fy_px *= y;
}

void MoveCentre(double least, double most, Random& random, SaidPicture& said) {
  const double angle = Between(0, 2 * 3.14159265358979, random);
  const double share = Between(least, most, random);
  said.camera.cx_px += share * std::cos(angle) * said.grey.cols;
  said.camera.cy_px += share * std::sin(angle) * said.grey.rows;
}

void BendLens(double least, double most, Random& random, SaidPicture& said) {
  auto* lens = std::get_if<RadialTangential>(&said.camera.lens);
  RadialTangential bent = lens == nullptr ? RadialTangential{} : *lens;
  const double k = Between(least, most, random);
  bent.k1 += random() % 2 == 0 ? k : -k;
  bent.k2 += Between(-0.1, 0.1, random);
  said.camera.lens = bent;
}

void UseOtherModel(Random& random, SaidPicture& said) {
  switch (random() % 3) {
    case 0:
      said.camera.lens = Equidistant{.k1 = Between(-0.1, 0.1, random)};
      return;
    case 1:
      said.camera.lens =
          DoubleSphere{.xi = Between(-0.3, 0.3, random), .alpha = Between(0.3, 0.7, random)};
      return;
    default:
      said.camera.lens = UnifiedSphere{.xi = Between(0.3, 1.5, random), .distortion = {}};
  }
}

void Resize(double factor, SaidPicture& said) {
  cv::resize(said.grey, said.grey, cv::Size(), factor, factor,
             factor < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
}

void Crop(Random& random, SaidPicture& said) {
  const int x = static_cast<int>(Between(0.02, 0.3, random) * said.grey.cols);
  const int y = static_cast<int>(Between(0.02, 0.3, random) * said.grey.rows);
  const bool from_left = random() % 2 == 0;
  const bool from_above = random() % 2 == 0;
  said.grey = said.grey(cv::Rect(from_left ? x : 0, from_above ? y : 0, said.grey.cols - x,
                                 said.grey.rows - y))
                  .clone();
}

void Pad(Random& random, SaidPicture& said) {
  const int x = static_cast<int>(Between(0.02, 0.2, random) * said.grey.cols);
  const int y = static_cast<int>(Between(0.02, 0.2, random) * said.grey.rows);
  cv::copyMakeBorder(said.grey, said.grey, y, 0, x, 0, cv::BORDER_CONSTANT, cv::Scalar(90));
}

void Mirror(Random& random, SaidPicture& said) {
  cv::flip(said.grey, said.grey, random() % 2 == 0 ? 1 : 0);
  said.has_no_place = true;
}

void TurnUpsideDown(SaidPicture& said) {
  cv::flip(said.grey, said.grey, -1);
  said.said_from_true = Rigid3d{ExpSO3({0, 0, 3.14159265358979}), {0, 0, 0}};
}

// Cameras that people have at hand, whatever took the picture.
void UseAnothers(Random& random, SaidPicture& said) {
  const RawCamera others[] = {
      {.fx_px = 718.856, .fy_px = 718.856, .cx_px = 607.1928, .cy_px = 185.2157, .lens = {}},
      {.fx_px = 517.3,
       .fy_px = 516.5,
       .cx_px = 318.6,
       .cy_px = 255.3,
       .lens =
           RadialTangential{
               .k1 = 0.2624, .k2 = -0.9531, .p1 = -0.0054, .p2 = 0.0026, .k3 = 1.1633}},
      {.fx_px = 458.654,
       .fy_px = 457.296,
       .cx_px = 367.215,
       .cy_px = 248.375,
       .lens =
           RadialTangential{
               .k1 = -0.28340811, .k2 = 0.07395907, .p1 = 0.00019359, .p2 = 1.76187114e-05}},
      {.fx_px = 535.4, .fy_px = 539.2, .cx_px = 320.1, .cy_px = 247.6, .lens = {}},
      {.fx_px = 190.97,
       .fy_px = 190.97,
       .cx_px = 254.9,
       .cy_px = 256.9,
       .lens = Equidistant{.k1 = 0.0034, .k2 = 0.0007, .k3 = -0.002, .k4 = 0.0002}},
      {.fx_px = 0.8 * said.grey.cols,
       .fy_px = 0.8 * said.grey.cols,
       .cx_px = 0.5 * said.grey.cols,
       .cy_px = 0.5 * said.grey.rows,
       .lens = {}}};
  said.camera = others[random() % std::size(others)];
}

struct Kind {
  std::string name;
  Change change;
};

const std::vector<Kind>& Kinds() {
  static const auto& kinds = *new std::vector<Kind>{
      {"focal lengths, to 3 times",
       [](Random& random, SaidPicture& said) {
         const double factor = Factor(1.08, 3, random);
         ScaleFocal(factor, factor, said);
       }},
      {"focal lengths, 0.5 to 8 %",
       [](Random& random, SaidPicture& said) {
         const double factor = Factor(1.005, 1.08, random);
         ScaleFocal(factor, factor, said);
       }},
      {"fx and fy apart, to 2 times",
       [](Random& random, SaidPicture& said) {
         ScaleFocal(Factor(1, 2, random), Factor(1, 2, random), said);
       }},
      {"fx and fy apart, to 5 %",
       [](Random& random, SaidPicture& said) {
         ScaleFocal(Factor(1, 1.05, random), Factor(1, 1.05, random), said);
       }},
      {"centre, 5 to 45 %",
       [](Random& random, SaidPicture& said) { MoveCentre(0.05, 0.45, random, said); }},
      {"centre, 0.5 to 5 %",
       [](Random& random, SaidPicture& said) { MoveCentre(0.005, 0.05, random, said); }},
      {"lens bent, k1 0.02 to 0.5",
       [](Random& random, SaidPicture& said) { BendLens(0.02, 0.5, random, said); }},
      {"lens left out or k1 0.01",
       [](Random&, SaidPicture& said) {
         const auto* lens = std::get_if<RadialTangential>(&said.camera.lens);
         const bool has_none = lens != nullptr && lens->IsZero();
         said.camera.lens = RadialTangential{.k1 = has_none ? 0.01 : 0};
       }},
      {"lens of another model", UseOtherModel},
      {"another's camera", UseAnothers},
      {"resized, to 3 times",
       [](Random& random, SaidPicture& said) { Resize(Factor(1.02, 2.5, random), said); }},
      {"cropped", Crop},
      {"padded", Pad},
      {"mirrored", Mirror},
      {"upside down", [](Random&, SaidPicture& said) { TurnUpsideDown(said); }},
      {"several of these", [](Random& random, SaidPicture& said) {
         ScaleFocal(Factor(1, 1.8, random), Factor(1, 1.8, random), said);
         MoveCentre(0, 0.2, random, said);
         BendLens(0, 0.3, random, said);
       }}};
  return kinds;
}

}  // namespace

const std::vector<std::string>& WrongKinds() {
  static const auto& names = *[] {
    auto* all = new std::vector<std::string>;
    for (const Kind& kind : Kinds()) all->push_back(kind.name);
    return all;
  }();
  return names;
}

SaidPicture SayWrongly(size_t kind, const cv::Mat& grey, const RawCamera& truth,
                       std::mt19937_64& random) {
  SaidPicture said{.grey = grey.clone(), .camera = truth, .said_from_true = {}};
  Kinds()[kind].change(random, said);
  return said;
}

}  // namespace corbslam::tests
