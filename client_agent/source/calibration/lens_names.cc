#include "client_agent/source/calibration/lens_names.h"

#include <algorithm>
#include <string>
#include <variant>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

enum class Kind { kRadialTangential, kEquidistant, kDoubleSphere, kUnified };

struct LensName {
  absl::string_view name;
  Kind kind;
};
constexpr LensName kNames[] = {{"none", Kind::kRadialTangential},
                               {"radial-tangential", Kind::kRadialTangential},
                               {"radtan", Kind::kRadialTangential},
                               {"plumb_bob", Kind::kRadialTangential},
                               {"rational_polynomial", Kind::kRadialTangential},
                               {"equidistant", Kind::kEquidistant},
                               {"fisheye", Kind::kEquidistant},
                               {"kannala-brandt", Kind::kEquidistant},
                               {"double-sphere", Kind::kDoubleSphere},
                               {"unified", Kind::kUnified}};

absl::Status WrongCount(absl::string_view lens, size_t given, absl::string_view wanted) {
  return absl::InvalidArgumentError(
      absl::StrCat(given, " numbers of a lens that is ", lens, ", which has ", wanted));
}

absl::StatusOr<RadialTangential> MakeRadialTangential(std::vector<double> d) {
  // Tilted and thin-prism models have up to 14 numbers, which tools write as 0 where they are not
  // used.
  while (d.size() > 8 && d.back() == 0) d.pop_back();
  if (d.size() != 0 && d.size() != 4 && d.size() != 5 && d.size() != 8) {
    return WrongCount("radial-tangential", d.size(), "none, 4, 5 or 8");
  }
  d.resize(8, 0.0);
  return RadialTangential{d[0], d[1], d[2], d[3], d[4], d[5], d[6], d[7]};
}

absl::StatusOr<LensModel> MakeLens(Kind kind, const std::vector<double>& d) {
  switch (kind) {
    case Kind::kRadialTangential:
      break;
    case Kind::kEquidistant:
      if (d.size() != 4) return WrongCount("equidistant", d.size(), "4");
      return Equidistant{d[0], d[1], d[2], d[3]};
    case Kind::kDoubleSphere:
      if (d.size() != 2) return WrongCount("a double sphere", d.size(), "2");
      return DoubleSphere{d[0], d[1]};
    case Kind::kUnified: {
      if (d.empty()) return WrongCount("a unified sphere", 0, "at least 1");
      ASSIGN_OR_RETURN(const RadialTangential bent, MakeRadialTangential({d.begin() + 1, d.end()}));
      return UnifiedSphere{d[0], bent};
    }
  }
  return MakeRadialTangential(d);
}

std::vector<double> Numbers(const RadialTangential& d) {
  if (d.IsZero()) return {};
  if (!d.IsRational()) return {d.k1, d.k2, d.p1, d.p2, d.k3};
  return {d.k1, d.k2, d.p1, d.p2, d.k3, d.k4, d.k5, d.k6};
}

std::vector<double> Numbers(const Equidistant& d) { return {d.k1, d.k2, d.k3, d.k4}; }

std::vector<double> Numbers(const DoubleSphere& d) { return {d.xi, d.alpha}; }

std::vector<double> Numbers(const UnifiedSphere& d) {
  std::vector<double> numbers = Numbers(d.distortion);
  numbers.insert(numbers.begin(), d.xi);
  return numbers;
}

}  // namespace

absl::StatusOr<LensModel> LensOfName(absl::string_view name, const std::vector<double>& numbers) {
  const std::string lower = absl::AsciiStrToLower(name);
  const LensName* const found =
      std::find_if(std::begin(kNames), std::end(kNames),
                   [&](const LensName& known) { return known.name == lower; });
  if (found != std::end(kNames)) return MakeLens(found->kind, numbers);
  std::string known;
  for (const LensName& each : kNames) absl::StrAppend(&known, known.empty() ? "" : ", ", each.name);
  return absl::InvalidArgumentError(absl::StrCat("a lens that is '", name, "', known are ", known));
}

std::vector<double> NumbersOf(const LensModel& lens) {
  return std::visit([](const auto& model) { return Numbers(model); }, lens);
}

}  // namespace corbslam::client_agent
