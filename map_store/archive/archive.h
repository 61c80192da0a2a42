// Turns values to bytes and back, for files of our own: little-endian, fields one after the other,
// containers with their size before them. Types take part by a function template
//
//   template <typename Archive, MayBeConst<Tombstone> T>
//   void Fields(Archive& archive, T& tombstone) { archive(tombstone.parent, ...); }
//
// that serves both ways. An enumeration that takes part says which value is its last
//
//   constexpr OverlapState LastValue(OverlapState) { return OverlapState::kFailed; }
#ifndef CORBSLAM_MAP_STORE_ARCHIVE_ARCHIVE_H_
#define CORBSLAM_MAP_STORE_ARCHIVE_ARCHIVE_H_

#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <deque>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "absl/container/btree_map.h"

namespace corbslam::map_store {

static_assert(std::endian::native == std::endian::little);

template <typename T, typename Named>
concept MayBeConst = std::same_as<std::remove_const_t<T>, Named>;

template <typename T>
concept PlainNumber = std::is_arithmetic_v<T> || std::is_enum_v<T>;

class ArchiveWriter {
 public:
  static constexpr bool kReads = false;

  template <typename... T>
  void operator()(const T&... values) {
    (Value(values), ...);
  }
  // Small pieces come by the million, so there is no call here, as std::string's own growing would
  // be one.
  void Raw(const void* bytes, size_t size) {
    if (size > bytes_.size() - used_) bytes_.resize(2 * bytes_.size() + size + 256);
    if (size > 0) std::memcpy(bytes_.data() + used_, bytes, size);
    used_ += size;
  }
  // Returns what was written; the writer is empty afterwards.
  std::string Take() {
    bytes_.resize(std::exchange(used_, 0));
    return std::exchange(bytes_, {});
  }

 private:
  template <PlainNumber T>
  void Value(const T& number) {
    Raw(&number, sizeof(number));
  }
  void Value(const std::string& text) {
    Size(text.size());
    Raw(text.data(), text.size());
  }
  template <typename T, size_t N>
  void Value(const std::array<T, N>& items) {
    for (const T& item : items) Value(item);
  }
  template <typename T>
  void Value(const std::vector<T>& items) {
    Items(items);
  }
  template <typename T>
  void Value(const std::deque<T>& items) {
    Items(items);
  }
  template <typename T>
  void Value(const std::set<T>& items) {
    Items(items);
  }
  template <typename K, typename V>
  void Value(const std::map<K, V>& items) {
    Items(items);
  }
  template <typename K, typename V>
  void Value(const absl::btree_map<K, V>& items) {
    Items(items);
  }
  template <typename A, typename B>
  void Value(const std::pair<A, B>& pair) {
    Value(pair.first);
    Value(pair.second);
  }
  template <typename... T>
  void Value(const std::variant<T...>& value) {
    Value(static_cast<uint8_t>(value.index()));
    std::visit([this](const auto& alternative) { this->Value(alternative); }, value);
  }
  template <typename T>
  requires(std::is_class_v<T>) void Value(const T& object) { Fields(*this, object); }

  void Size(size_t size) { Value(static_cast<uint64_t>(size)); }
  template <typename Container>
  void Items(const Container& items) {
    Size(items.size());
    for (const auto& item : items) Value(item);
  }

  // The first `used_` bytes of it are written.
  std::string bytes_;
  size_t used_ = 0;
};

// Reads what an ArchiveWriter wrote. It never reads beyond its bytes, and never takes more memory
// than they account for: once something is wrong, ok() is false and what is read is empty.
class ArchiveReader {
 public:
  static constexpr bool kReads = true;

  explicit ArchiveReader(std::string_view bytes) : rest_(bytes) {}

  template <typename... T>
  void operator()(T&... values) {
    (Value(values), ...);
  }
  void Raw(void* bytes, size_t size) {
    if (size > rest_.size()) return Fail();
    if (size > 0) std::memcpy(bytes, rest_.data(), size);
    rest_.remove_prefix(size);
  }
  void Fail() {
    ok_ = false;
    rest_ = {};
  }
  bool ok() const { return ok_; }
  // Returns whether all was read without an error.
  bool done() const { return ok_ && rest_.empty(); }
  size_t left() const { return rest_.size(); }

 private:
  template <PlainNumber T>
  void Value(T& number) {
    number = T();
    Raw(&number, sizeof(number));
    if constexpr (std::is_enum_v<T>) {
      if (number >= T() && number <= LastValue(number)) return;
      number = T();
      Fail();
    }
  }
  void Value(bool& flag) {
    uint8_t byte = 0;
    Raw(&byte, 1);
    if (byte > 1) Fail();
    flag = byte == 1;
  }
  void Value(std::string& text) {
    text.resize(Size(1));
    Raw(text.data(), text.size());
  }
  template <typename T, size_t N>
  void Value(std::array<T, N>& items) {
    for (T& item : items) Value(item);
  }
  template <typename T>
  void Value(std::vector<T>& items) {
    Append<T>(items);
  }
  template <typename T>
  void Value(std::deque<T>& items) {
    Append<T>(items);
  }
  template <typename T>
  void Value(std::set<T>& items) {
    for (size_t left = Size(1); left > 0 && ok_; --left) {
      T item{};
      Value(item);
      items.insert(items.end(), std::move(item));
    }
  }
  template <typename K, typename V>
  void Value(std::map<K, V>& items) {
    MapItems(items);
  }
  template <typename K, typename V>
  void Value(absl::btree_map<K, V>& items) {
    MapItems(items);
  }
  template <typename A, typename B>
  void Value(std::pair<A, B>& pair) {
    Value(pair.first);
    Value(pair.second);
  }
  template <typename... T>
  void Value(std::variant<T...>& value) {
    uint8_t index = 0;
    Value(index);
    Alternative<0>(index, value);
  }
  template <typename T>
  requires(std::is_class_v<T>) void Value(T& object) { Fields(*this, object); }

  template <size_t I, typename... T>
  void Alternative(size_t index, std::variant<T...>& value) {
    if constexpr (I < sizeof...(T)) {
      if (index == I) return Value(value.template emplace<I>());
      Alternative<I + 1>(index, value);
    } else {
      Fail();
    }
  }
  template <typename Map>
  void MapItems(Map& items) {
    for (size_t left = Size(1); left > 0 && ok_; --left) {
      typename Map::key_type key{};
      Value(key);
      Value(items[std::move(key)]);
    }
  }
  // Reads the number of items that take at least `bytes_each` bytes each; more than fit is an
  // error.
  size_t Size(size_t bytes_each) {
    uint64_t size = 0;
    Value(size);
    if (size <= rest_.size() / bytes_each) return size;
    Fail();
    return 0;
  }
  template <typename T, typename Container>
  void Append(Container& items) {
    for (size_t left = Size(1); left > 0 && ok_; --left) Value(items.emplace_back());
  }

  std::string_view rest_;
  bool ok_ = true;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ARCHIVE_ARCHIVE_H_
