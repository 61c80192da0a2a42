#include "slam/rendering/svg_text.h"

#include <cmath>
#include <cstdint>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace corbslam {
namespace {

constexpr char kReplacement[] = "\xEF\xBF\xBD";  // U+FFFD.
constexpr char kEllipsis[] = "\xE2\x80\xA6";

// Returns how many bytes a character that begins with this byte has; 0 if none begins so.
size_t LengthOf(uint8_t first) {
  if (first < 0x80) return 1;
  if (first >= 0xC2 && first < 0xE0) return 2;
  if (first >= 0xE0 && first < 0xF0) return 3;
  if (first >= 0xF0 && first < 0xF5) return 4;
  return 0;
}

struct Character {
  size_t bytes = 1;
  uint32_t code = 0;
  bool is_valid = false;
};

bool IsAllowed(uint32_t code, size_t bytes) {
  constexpr uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  if (code < kLeast[bytes]) return false;  // It is written longer than it is.
  if (code < 0x20) return code == '\t' || code == '\n' || code == '\r';
  if (code >= 0x7F && code < 0xA0) return false;
  if (code >= 0xD800 && code < 0xE000) return false;
  // Marks that turn the direction of what follows would let a name change its surroundings.
  if ((code >= 0x202A && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069)) return false;
  return code != 0xFFFE && code != 0xFFFF && code < 0x110000;
}

Character ReadCharacter(absl::string_view text) {
  Character character;
  const auto first = static_cast<uint8_t>(text[0]);
  const size_t bytes = LengthOf(first);
  if (bytes == 0 || bytes > text.size()) return character;
  constexpr uint32_t kFirstBits[] = {0, 0x7F, 0x1F, 0x0F, 0x07};
  character.code = first & kFirstBits[bytes];
  for (size_t i = 1; i < bytes; ++i) {
    const auto next = static_cast<uint8_t>(text[i]);
    if ((next & 0xC0) != 0x80) return character;
    character.code = (character.code << 6) | (next & 0x3F);
  }
  character.bytes = bytes;
  character.is_valid = IsAllowed(character.code, bytes);
  return character;
}

void AppendEscaped(absl::string_view character, std::string* escaped) {
  switch (character[0]) {
    case '&':
      escaped->append("&amp;");
      return;
    case '<':
      escaped->append("&lt;");
      return;
    case '>':
      escaped->append("&gt;");
      return;
    case '"':
      escaped->append("&quot;");
      return;
    case '\'':
      escaped->append("&#39;");
      return;
    default:
      absl::StrAppend(escaped, character);
  }
}

}  // namespace

std::string EscapeMarkup(absl::string_view text) {
  std::string escaped;
  escaped.reserve(text.size());
  while (!text.empty()) {
    const Character character = ReadCharacter(text);
    if (character.is_valid) {
      AppendEscaped(text.substr(0, character.bytes), &escaped);
    } else {
      escaped.append(kReplacement);
    }
    text.remove_prefix(character.bytes);
  }
  return escaped;
}

size_t CountCharacters(absl::string_view text) {
  size_t count = 0;
  for (; !text.empty(); text.remove_prefix(ReadCharacter(text).bytes)) ++count;
  return count;
}

std::string Shorten(absl::string_view text, size_t most) {
  if (CountCharacters(text) <= most) return std::string(text);
  size_t bytes = 0;
  for (size_t i = 0; i + 1 < most; ++i) bytes += ReadCharacter(text.substr(bytes)).bytes;
  return absl::StrCat(text.substr(0, bytes), kEllipsis);
}

std::string FormatShort(double number, int decimals) {
  if (!std::isfinite(number)) return "0";
  std::string text = absl::StrFormat("%.*f", decimals, number);
  if (text.find('.') != std::string::npos) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
  }
  return text == "-0" ? "0" : text;
}

}  // namespace corbslam
