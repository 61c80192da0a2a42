#include "services/convert/lens.h"

#include <variant>

#include "absl/strings/str_cat.h"
#include "services/convert/errors.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// The coefficients of a RadialTangential on the wire: five, or all eight.
constexpr int kPlainCoefficients = 5;
constexpr int kRationalCoefficients = 8;

void AddCoefficients(const RadialTangential& d, v1::RecordedCamera* proto) {
  for (const double coefficient : {d.k1, d.k2, d.p1, d.p2, d.k3}) {
    proto->add_distortion(coefficient);
  }
  if (!d.IsRational()) return;
  for (const double coefficient : {d.k4, d.k5, d.k6}) proto->add_distortion(coefficient);
}

// The model of a radial-tangential lens stays unsaid, so that programs that know no other read it.
void SetLens(const RadialTangential& lens, v1::RecordedCamera* proto) {
  if (!lens.IsZero()) AddCoefficients(lens, proto);
}

void SetLens(const Equidistant& lens, v1::RecordedCamera* proto) {
  proto->set_lens_model(v1::LENS_MODEL_EQUIDISTANT);
  for (const double k : {lens.k1, lens.k2, lens.k3, lens.k4}) proto->add_distortion(k);
}

void SetLens(const DoubleSphere& lens, v1::RecordedCamera* proto) {
  proto->set_lens_model(v1::LENS_MODEL_DOUBLE_SPHERE);
  proto->add_distortion(lens.xi);
  proto->add_distortion(lens.alpha);
}

void SetLens(const UnifiedSphere& lens, v1::RecordedCamera* proto) {
  proto->set_lens_model(v1::LENS_MODEL_UNIFIED_SPHERE);
  proto->add_distortion(lens.xi);
  AddCoefficients(lens.distortion, proto);
}

using Coefficients = google::protobuf::RepeatedField<double>;

// Reads the coefficients from `first` on.
absl::StatusOr<RadialTangential> ReadRadialTangential(const Coefficients& d, int first) {
  const int count = d.size() - first;
  if (count != kPlainCoefficients && count != kRationalCoefficients) {
    return BadLength("distortion", d.size(), first + kPlainCoefficients);
  }
  RadialTangential lens = {d[first], d[first + 1], d[first + 2], d[first + 3], d[first + 4], 0, 0,
                           0};
  if (count == kPlainCoefficients) return lens;
  lens.k4 = d[first + 5];
  lens.k5 = d[first + 6];
  lens.k6 = d[first + 7];
  return lens;
}

}  // namespace

void LensToProto(const LensModel& model, v1::RecordedCamera* proto) {
  std::visit([&](const auto& lens) { SetLens(lens, proto); }, model);
}

absl::StatusOr<LensModel> LensFromProto(const v1::RecordedCamera& proto) {
  const Coefficients& d = proto.distortion();
  switch (proto.lens_model()) {
    case v1::LENS_MODEL_UNSPECIFIED:
    case v1::LENS_MODEL_RADIAL_TANGENTIAL:
      if (d.empty()) return RadialTangential();
      return ReadRadialTangential(d, 0);
    case v1::LENS_MODEL_EQUIDISTANT:
      if (d.size() != 4) return BadLength("distortion", d.size(), 4);
      return Equidistant{d[0], d[1], d[2], d[3]};
    case v1::LENS_MODEL_DOUBLE_SPHERE:
      if (d.size() != 2) return BadLength("distortion", d.size(), 2);
      return DoubleSphere{d[0], d[1]};
    case v1::LENS_MODEL_UNIFIED_SPHERE: {
      if (d.empty()) return BadLength("distortion", 0, 1 + kPlainCoefficients);
      ASSIGN_OR_RETURN(const RadialTangential lens, ReadRadialTangential(d, 1));
      return UnifiedSphere{d[0], lens};
    }
    default:
      return absl::InvalidArgumentError(
          absl::StrCat("lens_model is ", static_cast<int>(proto.lens_model()), ", must be 0 to 4"));
  }
}

}  // namespace corbslam::services
