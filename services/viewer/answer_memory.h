// Bounds the memory of large answers.
#ifndef CORBSLAM_SERVICES_VIEWER_ANSWER_MEMORY_H_
#define CORBSLAM_SERVICES_VIEWER_ANSWER_MEMORY_H_

#include <atomic>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace corbslam::services {

// Counts the bytes of answers from when they come until they are sent. Thread-safe.
class AnswerMemory {
 public:
  explicit AnswerMemory(size_t max_bytes) : counted_(std::make_shared<Counted>(max_bytes)) {}

 private:
  struct Counted {
    explicit Counted(size_t limit) : max_bytes(limit) {}

    const size_t max_bytes;
    std::atomic<size_t> bytes = 0;
  };
  // What one answer takes of the memory.
  struct Share {
    explicit Share(std::shared_ptr<Counted> all) : counted(std::move(all)) {}
    ~Share() { counted->bytes -= bytes; }
    Share(const Share&) = delete;
    Share& operator=(const Share&) = delete;

    const std::shared_ptr<Counted> counted;
    size_t bytes = 0;
    std::string text;
  };

 public:
  // An answer that grows. Not thread-safe.
  class Body {
   public:
    // Appends a message behind its length in four bytes, the least significant first.
    // RESOURCE_EXHAUSTED: all answers together would have too many bytes.
    absl::Status AddMessage(absl::string_view message) {
      std::string& text = share_->text;
      const size_t needed = text.size() + 4 + message.size();
      if (needed > text.capacity()) {
        // What is copied while it grows counts, too.
        const size_t capacity = needed + needed / 2;
        Counted& counted = *share_->counted;
        const size_t more = capacity - share_->bytes;
        if (counted.bytes.fetch_add(more) + more > counted.max_bytes) {
          counted.bytes -= more;
          return absl::ResourceExhaustedError(
              absl::StrCat("answers to other pages have ", counted.bytes.load(), " bytes; with ",
                           more, " more they pass the limit of ", counted.max_bytes,
                           "; try again soon, or ask for less"));
        }
        share_->bytes = capacity;
        text.reserve(capacity);
      }
      for (int shift = 0; shift < 32; shift += 8) {
        text += static_cast<char>((message.size() >> shift) & 0xff);
      }
      text.append(message.data(), message.size());
      return absl::OkStatus();
    }
    size_t size() const { return share_->text.size(); }
    // Returns the answer, which counts as long as somebody holds it.
    std::shared_ptr<const std::string> Take() && {
      const std::string* const text = &share_->text;
      return {std::move(share_), text};
    }

   private:
    friend class AnswerMemory;

    explicit Body(std::shared_ptr<Share> share) : share_(std::move(share)) {}

    std::shared_ptr<Share> share_;
  };

  Body Begin() { return Body(std::make_shared<Share>(counted_)); }
  size_t bytes() const { return counted_->bytes; }

 private:
  const std::shared_ptr<Counted> counted_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_VIEWER_ANSWER_MEMORY_H_
