#include "slam/rendering/paint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace corbslam {
namespace {

// The ramp's colours at equal distances. They grow lighter and go from blue to yellow, which those
// who don't tell red from green see, too: a quarter of the ramp apart, colours differ by 16
// (CIELAB) for them.
constexpr std::array<Paint, 5> kRamp = {{{nullptr, 35, 90, 215},
                                         {nullptr, 105, 95, 190},
                                         {nullptr, 165, 100, 140},
                                         {nullptr, 205, 115, 80},
                                         {nullptr, 225, 140, 0}}};

uint8_t Mix(uint8_t from, uint8_t to, double share) {
  return static_cast<uint8_t>(std::lround(from + share * (to - from)));
}

constexpr size_t kSeries = 8;
constexpr size_t kMostSeries = 24;
constexpr std::array<uint32_t, kSeries> kOnLight = {0x0072b2, 0xc94f00, 0x00805c, 0xa8347d,
                                                    0x7a6500, 0x2f8fb8, 0x5b4bb0, 0x5a5a5a};
constexpr std::array<uint32_t, kSeries> kOnDark = {0x5cb8f0, 0xff9a4d, 0x2fd6a0, 0xf08bc8,
                                                   0xf0e060, 0x9ad7f5, 0xb5a6ff, 0xc8c8c8};

// What the colours of a further round are mixed with, on light and on dark ground.
struct Shade {
  uint32_t on_light = 0;
  uint32_t on_dark = 0;
  double share = 0;
};
constexpr std::array<Shade, kMostSeries / kSeries> kShades = {
    {{}, {0x000000, 0x303840, 0.45}, {0xffffff, 0xffffff, 0.45}}};

uint32_t Mix(uint32_t from, uint32_t to, double share) {
  uint32_t mixed = 0;
  for (const int shift : {16, 8, 0}) {
    const auto channel = [shift](uint32_t colour) { return static_cast<uint8_t>(colour >> shift); };
    mixed |= uint32_t{Mix(channel(from), channel(to), share)} << shift;
  }
  return mixed;
}

const std::vector<NamedPaint>& AllSeries() {
  static const auto& names = *new std::vector<std::string>([] {
    std::vector<std::string> made;
    for (size_t i = 1; i <= kMostSeries; ++i) made.push_back(absl::StrCat("series-", i));
    return made;
  }());
  static const auto& series = *new std::vector<NamedPaint>([] {
    std::vector<NamedPaint> made;
    for (size_t i = 0; i < kMostSeries; ++i) {
      const Shade& shade = kShades[i / kSeries];
      made.emplace_back(names[i].c_str(), Mix(kOnLight[i % kSeries], shade.on_light, shade.share),
                        Mix(kOnDark[i % kSeries], shade.on_dark, shade.share));
    }
    return made;
  }());
  return series;
}

// Returns the number by which a name asks for its colour.
size_t WantedNumber(const std::string& robot) {
  const size_t last = robot.find_last_of("0123456789");
  if (last == std::string::npos) {
    const int letter =
        robot.empty()
            ? 0
            : static_cast<unsigned char>(absl::ascii_tolower(static_cast<unsigned char>(robot[0])));
    return static_cast<size_t>(letter - 'a' + 16 * static_cast<int>(kSeries)) % kSeries;
  }
  // Of a decimal number its last three digits decide what is left of it by eight.
  size_t number = 0;
  const size_t before = robot.find_last_not_of("0123456789", last);
  size_t at = before == std::string::npos ? 0 : before + 1;
  for (at = std::max(at, last >= 2 ? last - 2 : 0); at <= last; ++at) {
    number = 10 * number + static_cast<size_t>(robot[at] - '0');
  }
  return number % kSeries;
}

size_t FreeNumber(size_t wanted, const std::set<size_t>& taken) {
  for (size_t round = 0;; ++round) {
    for (size_t i = 0; i < kSeries; ++i) {
      const size_t number = round * kSeries + (wanted + i) % kSeries;
      if (!taken.contains(number)) return number;
    }
  }
}

// Compares names by their bytes, runs of digits by their length first: "robot2" comes before
// "robot10", "Bravo" before "alpha". The page's byName() is the same.
bool IsBefore(const std::string& a, const std::string& b) {
  const auto digits = [](const std::string& text, size_t at) {
    const size_t end = text.find_first_not_of("0123456789", at);
    return std::min(end, text.size()) - at;
  };
  size_t at = 0;
  while (at < a.size() && at < b.size()) {
    const size_t run_a = digits(a, at);
    const size_t run_b = digits(b, at);
    if (run_a != run_b && run_a > 0 && run_b > 0) return run_a < run_b;
    if (a[at] != b[at]) {
      return static_cast<unsigned char>(a[at]) < static_cast<unsigned char>(b[at]);
    }
    ++at;
  }
  return a.size() < b.size();
}

}  // namespace

const NamedPaint& SeriesPaint(size_t number) { return AllSeries()[number % kMostSeries]; }

std::map<std::string, size_t> NumberRobots(const std::set<std::string>& robots) {
  std::vector<std::string> names(robots.begin(), robots.end());
  std::ranges::sort(names, IsBefore);
  std::map<std::string, size_t> numbers;
  std::set<size_t> taken;
  for (const std::string& name : names) {
    const size_t number = FreeNumber(WantedNumber(name), taken);
    taken.insert(number);
    numbers[name] = number;
  }
  return numbers;
}

std::string PaintVariables(bool on_dark) {
  std::vector<NamedPaint> paints = {kInk,     kPaper,  kMuted,      kGrid, kOwn,
                                    kOwnEdge, kOthers, kOthersEdge, kTruth};
  paints.insert(paints.end(), AllSeries().begin(), AllSeries().end());
  std::string text;
  for (const NamedPaint& paint : paints) {
    const uint32_t light = uint32_t{paint.red} << 16 | uint32_t{paint.green} << 8 | paint.blue;
    absl::StrAppend(&text, "--", paint.variable, ": ",
                    absl::StrFormat("#%06x", on_dark ? paint.on_dark : light), "; ");
  }
  return text;
}

Paint RampPaint(double share) {
  if (!std::isfinite(share)) return {nullptr, 140, 140, 140};
  const double at = std::clamp(share, 0.0, 1.0) * (kRamp.size() - 1);
  const size_t index = std::min(static_cast<size_t>(at), kRamp.size() - 2);
  const Paint& low = kRamp[index];
  const Paint& high = kRamp[index + 1];
  const double rest = at - static_cast<double>(index);
  return {nullptr, Mix(low.red, high.red, rest), Mix(low.green, high.green, rest),
          Mix(low.blue, high.blue, rest)};
}

}  // namespace corbslam
