// Splits what is too long for one message into several of the same kind.
#ifndef CORBSLAM_SERVICES_CONVERT_PARTS_H_
#define CORBSLAM_SERVICES_CONVERT_PARTS_H_

#include <algorithm>
#include <cstddef>
#include <deque>
#include <functional>
#include <iterator>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "services/convert/ids.h"
#include "slam/util/ids.h"

namespace corbslam::services {

// Fills one part after the other. `start` writes what each part begins with and returns the writer
// of its table. Not thread-safe.
template <typename Message>
class PartWriter {
 public:
  using Start = std::function<SlotWriter(Message&)>;

  PartWriter(size_t part_bytes, Start start) : part_bytes_(part_bytes), start_(std::move(start)) {
    NextPart();
  }

  Message& part() { return parts_.back(); }
  SlotWriter& slots() { return *slots_; }

  // Makes room for an item of about `bytes`; it may begin a new part.
  void Reserve(size_t bytes) {
    if (bytes > room_ && room_ < part_bytes_) NextPart();
    room_ -= std::min(room_, bytes);
  }

  // Begins a new part, unless nothing was written to this one.
  void BeginPart() {
    if (room_ < part_bytes_) NextPart();
  }

  // Calls write(items of one part) until all are written.
  template <typename Item, typename Write>
  void Spread(const std::vector<Item>& items, size_t bytes_each, const Write& write) {
    for (size_t begin = 0; begin < items.size();) {
      if (room_ < bytes_each && room_ < part_bytes_) NextPart();
      const size_t fitting = std::max<size_t>(1, room_ / bytes_each);
      const size_t count = std::min(items.size() - begin, fitting);
      write(std::span<const Item>(items).subspan(begin, count));
      room_ -= std::min(room_, count * bytes_each);
      begin += count;
    }
  }

  std::vector<Message> Take() && {
    return {std::make_move_iterator(parts_.begin()), std::make_move_iterator(parts_.end())};
  }

 private:
  void NextPart() {
    parts_.emplace_back();
    slots_ = std::make_unique<SlotWriter>(start_(parts_.back()));
    room_ = part_bytes_;
  }

  const size_t part_bytes_;
  const Start start_;
  // A deque keeps the parts' addresses: the SlotWriter points into the last one.
  std::deque<Message> parts_;
  std::unique_ptr<SlotWriter> slots_;
  size_t room_ = 0;
};

template <typename Item>
void AppendAll(std::vector<Item>& to, std::vector<Item>& from) {
  to.insert(to.end(), std::make_move_iterator(from.begin()), std::make_move_iterator(from.end()));
}

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CONVERT_PARTS_H_
